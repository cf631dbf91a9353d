#include "drivers/lidar/sweep_assembler.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "drivers/lidar/azimuth_repair.hpp"
#include "drivers/lidar/lidar_model.hpp"

namespace infuse::lidar {
namespace {

/// A gap in the numbers of packets that is no loss, but numbers that were set.
constexpr uint32_t kMaxNumberGap = 10'000'000;
/// Longer silences count as this long.
constexpr int64_t kMaxGapNs = 3'600'000'000'000;

int to_centidegrees(double degrees) {
  return static_cast<int>(std::lround(degrees * 100) + kCentidegreesPerTurn) % kCentidegreesPerTurn;
}

/// Adds the rotation within a packet, unless the sensor has skipped a part of the turn there.
void add_rotation(const FiringPlan& plan, int64_t period_ns, RotationRate& rotation) {
  if (plan.last_jump > 0) return;
  rotation.add(azimuth_advance(plan.sequences[0].azimuth, plan.last().azimuth),
               static_cast<int64_t>(plan.count - 1) * period_ns);
}

}  // namespace

SweepAssembler::SweepAssembler(const DecoderOptions& options, const ClockModelOptions& clock,
                               const SequenceTiming& timing, ReturnReader& reader,
                               PacketCounters& counters, Losses& losses)
    : beams_(options.model->beams),
      max_span_(options.max_span),
      timing_(timing),
      reader_(reader),
      counters_(counters),
      losses_(losses),
      clock_(clock),
      order_(clock.modulo),
      cutter_(to_centidegrees(options.cut_azimuth)) {}

void SweepAssembler::require_pulled() const {
  if (has_following_) throw std::logic_error("a packet was pushed before pull returned false");
}

/// Orders a packet behind the held one, or before it if it is late.
std::optional<ArrivalOrder::Verdict> SweepAssembler::push(const Datagram& datagram,
                                                          const PacketHeader& header) {
  require_pulled();
  const ArrivalOrder::Verdict verdict = order_.add(header.counter, datagram.stamp);
  if (verdict.arrival == Arrival::kDuplicate) {
    ++counters_.duplicates;
    return std::nullopt;
  }
  if (verdict.arrival == Arrival::kTooLate) {
    ++counters_.too_late;
    return std::nullopt;
  }
  following_->header = header;
  following_->bytes.assign(datagram.payload.begin(), datagram.payload.end());
  stamp_packet(verdict, datagram.stamp);
  ++counters_.packets;
  if (verdict.arrival == Arrival::kLate || !has_held_) std::swap(held_, following_);
  has_following_ = has_held_;
  has_held_ = true;
  return verdict;
}

/// Sets the times of the packet that was received.
void SweepAssembler::stamp_packet(const ArrivalOrder::Verdict& verdict, Stamp host) {
  ReceivedPacket& packet = *following_;
  const bool late = verdict.arrival == Arrival::kLate;
  const bool first = verdict.arrival == Arrival::kFirst;
  packet.after_clock_jump = verdict.arrival == Arrival::kClockJump;
  packet.device_ns =
      first ? packet.header.counter.count() : newest_device_ns_ + verdict.delay.count();
  packet.refused_before = late ? 0 : std::exchange(refused_, 0);
  counters_.clock_jumps += packet.after_clock_jump ? 1 : 0;
  if (late) {
    ++counters_.out_of_order;
    packet.stamp = clock_.to_host(packet.header.counter);
    return;
  }
  // A packet is sent when it is full, and its counter is that of its first firing.
  const Duration filling(timing_.period_ns * packet.header.sequences);
  packet.stamp = clock_.update(packet.header.counter, host - filling);
  newest_device_ns_ = packet.device_ns;
}

bool SweepAssembler::pull(Sweep& sweep) {
  while (true) {
    if (!decoding_) {
      if (!has_held_ || (!has_following_ && !finished_)) break;
      begin_decoding(has_following_ ? following_ : nullptr);
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

/// Plans the held packet's sequences and the ends of sweeps among them.
void SweepAssembler::begin_decoding(const ReceivedPacket* following) {
  repair_held_azimuths(following);
  std::optional<FollowingPacket> next;
  if (following != nullptr && !following->after_clock_jump &&
      following->header.azimuth[0] != kNoAzimuth) {
    next = FollowingPacket{following->header.azimuth[0], following->device_ns - held_->device_ns};
  }
  plan_firings(held_->header.azimuths(), next, last_decoded_.step, rotation_.per_ns(), timing_,
               plan_);
  plan_cuts();
  add_rotation(plan_, timing_.period_ns, rotation_);
  last_decoded_ = {true, plan_.last().azimuth, plan_.last().step,
                   held_->device_ns + plan_.last().time_ns + timing_.period_ns,
                   held_->header.number};
  next_sequence_ = 0;
  decoding_ = true;
}

void SweepAssembler::plan_cuts() {
  gap_from_.reset();
  lost_before_first_ = 0;
  bool lossy_jump = false;
  if (held_->after_clock_jump || !last_decoded_.valid) {
    cutter_.restart();
  } else {
    detect_gap(plan_.sequences[0]);
    lossy_jump = plan_.sequences[0].after_jump && lost_before_first_ > 0;
  }
  cutter_.process_packet(plan_, lossy_jump, cut_before_);
}

/// Replaces azimuths of the held packet that cannot be the sensor's.
void SweepAssembler::repair_held_azimuths(const ReceivedPacket* following) {
  const auto directly = [&](int64_t gap_ns) { return std::abs(gap_ns) <= timing_.period_ns / 2; };
  PacketHeader& header = held_->header;
  std::optional<int> before;
  std::optional<int> after;
  if (last_decoded_.valid && directly(held_->device_ns - last_decoded_.end_ns)) {
    before = last_decoded_.azimuth;
  }
  if (is_smooth(header.azimuths(), before.value_or(header.azimuth[0]), timing_.max_step)) return;
  const int64_t end_ns = held_->device_ns + timing_.period_ns * header.sequences;
  if (following != nullptr && directly(following->device_ns - end_ns)) {
    after = following->header.azimuth[0];
  }
  counters_.stray_azimuths += repair_azimuths(header.azimuths(), before, after, timing_.max_step);
}

/// Number of packets missing between the last decoded packet and the held one: by their numbers, or
/// by the time between them without the part of the turn that the sensor does not scan.
int64_t SweepAssembler::count_missing(int64_t gap_ns, int64_t pause_ns) const {
  if (held_->header.number && last_decoded_.number) {
    const uint32_t missing = *held_->header.number - *last_decoded_.number - 1;
    if (missing <= kMaxNumberGap) return missing;
  }
  const int64_t packet_ns = timing_.period_ns * held_->header.sequences;
  return std::max<int64_t>((gap_ns - pause_ns + packet_ns / 2) / packet_ns, 0);
}

/// Classifies the gap between the last decoded packet and the held one: none, lost packets, or the
/// part of the turn that the sensor does not scan.
void SweepAssembler::detect_gap(PlannedSequence& first) {
  const int64_t gap_ns = std::min(held_->device_ns - last_decoded_.end_ns, kMaxGapNs);
  const int64_t period_ns = timing_.period_ns;
  const int64_t pause_ns =
      cutter_.pause_within(last_decoded_.azimuth, gap_ns, period_ns, rotation_);
  const int64_t missing = count_missing(gap_ns, pause_ns);
  first.advance = azimuth_advance(last_decoded_.azimuth, first.azimuth);
  first.after_jump =
      first.advance > timing_.max_step &&
      (missing == 0 || pause_ns > 0 || cutter_.is_known_jump(last_decoded_.azimuth, first.azimuth));
  lost_before_first_ = static_cast<uint32_t>(missing);
  // A refused packet has arrived: it is counted by its fault.
  const uint32_t lost = lost_before_first_ - std::min(lost_before_first_, held_->refused_before);
  const int64_t turned = last_decoded_.step * (gap_ns + period_ns) / period_ns;
  if (lost > 0) losses_.add_missing(lost, turned >= kCentidegreesPerTurn);
  if (first.after_jump || missing == 0) return;

  const int64_t turns = (turned - first.advance + kCentidegreesPerTurn / 2) / kCentidegreesPerTurn;
  first.advance += static_cast<int32_t>(std::clamp<int64_t>(turns, 0, 1000) * kCentidegreesPerTurn);
  gap_from_ = last_decoded_.azimuth + last_decoded_.step;
}

/// True when a sweep is complete; false when the held packet is.
bool SweepAssembler::decode(Sweep& sweep) {
  const HeldPacket packet{held_->bytes, held_->header, held_->device_ns};
  while (next_sequence_ < plan_.count) {
    const size_t first = next_sequence_;
    const PlannedSequence& start = plan_.sequences[first];
    const int64_t start_ns = held_->device_ns + start.time_ns;
    if (writer_.is_open()) {
      if (first == 0 && lost_before_first_ > 0) {
        writer_.add_lost_packets(std::exchange(lost_before_first_, 0));
      }
      if (cut_before_[first] || !writer_.accepts(start_ns, max_span_)) {
        close();
        return true;
      }
      if (first == 0 && gap_from_) writer_.add_gap(*gap_from_, start.azimuth);
    } else {
      writer_.open(sweep, beams_, start_ns, held_->stamp + Duration(start.time_ns));
    }
    size_t last = first + 1;
    while (last < plan_.count && !cut_before_[last]) ++last;
    reader_.append(packet, plan_, first, last, writer_);
    next_sequence_ = last;
  }
  return false;
}

void SweepAssembler::close() { writer_.close(clock_.state(), sweeps_++); }

}  // namespace infuse::lidar
