#include "drivers/ouster/turn_assembler.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace infuse::ouster {
namespace {

/// Difference of two numbers of turns, which wrap after 16 bits, FUSA: after 32.
int64_t turns_between(uint32_t earlier, uint32_t later, bool fusa) {
  const uint32_t difference = later - earlier;
  if (fusa) return static_cast<int32_t>(difference);
  return static_cast<int16_t>(difference);
}

}  // namespace

TurnAssembler::TurnAssembler(const Metadata& metadata, const lidar::DecoderOptions& options,
                             const ClockModelOptions& clock, lidar::PacketCounters& counters,
                             lidar::Losses& losses)
    : layout_(metadata),
      grid_(metadata, options.cut_azimuth),
      turns_per_second_(metadata.turns_per_second),
      max_span_(options.max_span),
      counters_(counters),
      losses_(losses),
      clock_(clock),
      order_(clock.modulo),
      writer_(metadata, grid_, options.instruction_set) {}

void TurnAssembler::require_pulled() const {
  if (has_following_) throw std::logic_error("a packet was pushed before pull returned false");
}

/// Orders a packet behind the held one, or before it if it is late.
std::optional<lidar::ArrivalOrder::Verdict> TurnAssembler::push(const Datagram& datagram,
                                                                const lidar::PacketHeader&) {
  require_pulled();
  if (!read(datagram)) {
    ++counters_.packets;
    ++refused_;  // it has arrived, though without data
    return std::nullopt;
  }
  const Column& first = following_->packet.columns[following_->first];
  const auto verdict = order_.add(Duration(first.device_ns), datagram.stamp);
  if (verdict.arrival == lidar::Arrival::kDuplicate) {
    ++counters_.duplicates;
    return std::nullopt;
  }
  if (verdict.arrival == lidar::Arrival::kTooLate) {
    ++counters_.too_late;
    return std::nullopt;
  }
  stamp_packet(verdict, datagram.stamp);
  ++counters_.packets;
  if (verdict.arrival == lidar::Arrival::kLate || !has_held_) std::swap(held_, following_);
  has_following_ = has_held_;
  has_held_ = true;
  return verdict;
}

/// Copies the payload. False if it has no valid column.
bool TurnAssembler::read(const Datagram& datagram) {
  ReceivedPacket& received = *following_;
  received.bytes.assign(datagram.payload.begin(), datagram.payload.end());
  const auto packet = parse_packet(layout_, received.bytes);
  if (!packet) return false;
  received.packet = *packet;
  const std::span columns = std::span(received.packet.columns).first(packet->count);
  const auto first = std::ranges::find(columns, true, &Column::valid);
  if (first == columns.end()) return false;
  received.first = static_cast<uint16_t>(first - columns.begin());
  received.last = static_cast<uint16_t>(columns.size() - 1);
  while (!columns[received.last].valid) --received.last;
  return true;
}

void TurnAssembler::stamp_packet(const lidar::ArrivalOrder::Verdict& verdict, Stamp host) {
  ReceivedPacket& packet = *following_;
  const Duration first(packet.packet.columns[packet.first].device_ns);
  packet.after_restart = verdict.arrival == lidar::Arrival::kClockJump;
  counters_.clock_jumps += packet.after_restart ? 1 : 0;
  packet.refused_before = 0;
  if (verdict.arrival == lidar::Arrival::kLate) {
    ++counters_.out_of_order;
    packet.stamp = clock_.to_host(first);
    return;
  }
  // A packet is sent when its last column has fired.
  const Duration last(packet.packet.columns[packet.last].device_ns);
  packet.stamp = clock_.update(last, host) - (last - first);
  packet.refused_before = std::exchange(refused_, 0);
}

bool TurnAssembler::pull(Sweep& sweep) {
  while (true) {
    if (!decoding_) {
      if (!has_held_ || (!has_following_ && !finished_)) break;
      begin_decoding();
    }
    if (decode(sweep)) return true;
    decoding_ = false;
    has_held_ = has_following_;
    has_following_ = false;
    std::swap(held_, following_);
    if (!finished_) break;
  }
  if (!finished_ || !writer_.is_open()) return false;
  close();
  return true;
}

/// Numbers the held packet's columns, and counts what is missing before it.
void TurnAssembler::begin_decoding() {
  const Packet& packet = held_->packet;
  const int64_t turn = turn_of_held();
  const uint16_t first_id = packet.columns[held_->first].measurement_id;
  for (uint16_t i = held_->first; i <= held_->last; ++i) {
    const Column& column = packet.columns[i];
    if (!column.valid) continue;
    // The frame id is the first column's; the others may lie in the next turn.
    places_[i] =
        grid_.place(turn + (column.measurement_id < first_id ? 1 : 0), column.measurement_id);
  }
  lost_before_ = 0;
  if (has_last_) detect_loss();
  has_last_ = true;
  last_frame_ = packet.frame_id;
  last_turn_ = turn;
  next_place_ = places_[held_->last] + packet.count - held_->last;
  last_device_ns_ = packet.columns[held_->last].device_ns;
  next_column_ = held_->first;
  decoding_ = true;
}

/// Turn of the held packet's frame. A sensor that has started again counts anew.
int64_t TurnAssembler::turn_of_held() {
  if (!has_last_) return 0;
  const int64_t turns = turns_between(last_frame_, held_->packet.frame_id, layout_.fusa_header);
  const double seconds =
      static_cast<double>(held_->packet.columns[held_->first].device_ns - last_device_ns_) * 1e-9;
  const double deviation = std::abs(static_cast<double>(turns) - seconds * turns_per_second_);
  const bool plausible =
      turns >= 0 && (turns_per_second_ == 0 || deviation <= 2 + 0.05 * seconds * turns_per_second_);
  if (plausible && !held_->after_restart) return last_turn_ + turns;
  has_last_ = false;
  return last_turn_ + 2;
}

/// Number of packets that hold so many columns of one sweep.
int64_t TurnAssembler::packets_of(int64_t columns) const {
  return (columns + layout_.columns - 1) / layout_.columns;
}

/// Counts the packets missing between the last decoded packet and the held one.
void TurnAssembler::detect_loss() {
  const int64_t columns = grid_.expected(next_place_, places_[held_->first] - held_->first);
  if (columns == 0) return;
  const int64_t sweeps = columns / grid_.columns_per_sweep();
  const int64_t missing = sweeps * packets_of(grid_.columns_per_sweep()) +
                          packets_of(columns % grid_.columns_per_sweep());
  // A refused packet has arrived: it is counted by its fault.
  const int64_t lost = missing - std::min<int64_t>(missing, held_->refused_before);
  lost_before_ = static_cast<uint32_t>(lost);
  if (lost == 0) return;
  losses_.add_missing(static_cast<uint64_t>(lost), columns >= grid_.columns_per_sweep());
}

/// True when a sweep is complete; false when the held packet is.
bool TurnAssembler::decode(Sweep& sweep) {
  const Packet& packet = held_->packet;
  while (next_column_ <= held_->last) {
    const Column& first = packet.columns[next_column_];
    if (!first.valid) {
      ++next_column_;
      continue;
    }
    const int64_t number = grid_.sweep(places_[next_column_]);
    if (writer_.is_open()) {
      writer_.add_lost_packets(std::exchange(lost_before_, 0));
      if (number != open_sweep_ || !writer_.accepts(first.device_ns, max_span_)) {
        close();
        return true;
      }
    } else {
      const int64_t after_ns = first.device_ns - packet.columns[held_->first].device_ns;
      writer_.open(sweep, first.device_ns, held_->stamp + Duration(after_ns));
      open_sweep_ = number;
    }
    const uint16_t end = end_of_run(next_column_, number);
    writer_.append(std::span(packet.columns).subspan(next_column_, size_t{end} - next_column_));
    next_column_ = end;
  }
  return false;
}

/// Index behind the last column from `first` on that belongs to this sweep.
uint16_t TurnAssembler::end_of_run(uint16_t first, int64_t sweep) const {
  uint16_t end = first;
  while (end <= held_->last &&
         (!held_->packet.columns[end].valid || grid_.sweep(places_[end]) == sweep)) {
    ++end;
  }
  return end;
}

void TurnAssembler::close() { writer_.close(clock_.state(), sweeps_++); }

}  // namespace infuse::ouster
