#include "drivers/velodyne/sweep_assembler.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "drivers/velodyne/azimuth_repair.hpp"

namespace infuse::velodyne {
namespace {

int to_centidegrees(double degrees) {
  return static_cast<int>(std::lround(degrees * 100) + kCentidegreesPerTurn) % kCentidegreesPerTurn;
}

/// Adds a packet's steps to the rate of rotation.
void add_steps(const FiringPlan& plan, int64_t period_ns, RotationRate& rotation) {
  int64_t turned = 0;
  int64_t steps = 0;
  for (size_t i = 1; i < plan.count; ++i) {
    const bool step = !plan.sequences[i].after_jump;
    turned += step ? plan.sequences[i].advance : 0;
    steps += step ? 1 : 0;
  }
  rotation.add(turned, steps * period_ns);
}

}  // namespace

std::optional<std::string> SweepAssemblerOptions::invalid() const {
  if (!(cut_azimuth >= -360 && cut_azimuth <= 360)) {
    return "cut_azimuth must be in -360 ... 360 degrees";
  }
  if (max_span < Duration(50'000'000) || max_span > Duration(2'000'000'000)) {
    return "max_span must be in 0.05 ... 2 s";
  }
  if (calibration) return calibration->invalid(model_info(model));
  return std::nullopt;
}

SweepAssembler::SweepAssembler(const SweepAssemblerOptions& options)
    : options_(options),
      info_(model_info(options.model)),
      calibration_source_(options.calibration ? CalibrationSource::kFile
                                              : CalibrationSource::kBuiltIn),
      calibration_(options.calibration ? *options.calibration
                                       : built_in_calibration(options.model)),
      table_(options.model, calibration_, info_.cycle),
      calibration_stream_(options.model),
      cycle_estimator_(info_),
      clock_(ClockModelOptions()),
      cutter_(to_centidegrees(options.cut_azimuth)),
      writer_(return_kernel(options.instruction_set)),
      sender_(options.sender) {}

void SweepAssembler::push(const Datagram& datagram) {
  if (has_following_) throw std::logic_error("SweepAssembler::push before pull returned false");
  finished_ = false;
  if (sender_.refuses(datagram.sender)) {
    ++counters_.wrong_sender;
    return;
  }
  const auto packet = parse_packet(info_, datagram.payload);
  if (!packet && sender_.sender() != 0 && datagram.sender != sender_.sender()) {
    ++counters_.wrong_sender;
    return;
  }
  if (!packet) {
    counters_.count_malformed(packet.error());
    if (packet.error() != PacketFault::kSize) ++refused_;
    return;
  }
  if (!accept(datagram)) return;
  order_packet(datagram, *packet);
}

bool SweepAssembler::accept(const Datagram& datagram) {
  const uint64_t changes = sender_.changes();
  const bool accepted = sender_.accept(datagram.sender, datagram.stamp);
  if (sender_.changes() != changes) forget_unit();
  if (!accepted) ++counters_.wrong_sender;
  return accepted;
}

/// Another unit sends from now on: the calibration that the stream contained is not its own.
void SweepAssembler::forget_unit() {
  if (calibration_source_ == CalibrationSource::kStream) {
    calibration_source_ = CalibrationSource::kBuiltIn;
  }
  calibration_stream_.restart();
}

/// Orders a packet behind the held one, or before it if it is late.
void SweepAssembler::order_packet(const Datagram& datagram, const Packet& packet) {
  const ArrivalOrder::Verdict verdict = order_.add(packet.counter_us, datagram.stamp);
  const std::chrono::microseconds counter(packet.counter_us);
  // A packet is sent when it is full, and its counter is that of its first firing.
  const Stamp sent = datagram.stamp - packet_period(info_, table_.cycle, packet.dual());
  following_->packet = packet;
  following_->after_clock_jump = verdict.arrival == Arrival::kClockJump;
  following_->refused_before = 0;
  following_->device_ns = newest_device_ns_ + verdict.delay_us * 1000;
  switch (verdict.arrival) {
    case Arrival::kDuplicate:
      ++counters_.duplicates;
      return;
    case Arrival::kTooLate:
      ++counters_.too_late;
      return;
    case Arrival::kFirst:
      following_->device_ns = packet.counter_us * int64_t{1000};
      following_->stamp = clock_.update(counter, sent);
      break;
    case Arrival::kClockJump:
      ++counters_.clock_jumps;
      [[fallthrough]];
    case Arrival::kNext:
      following_->stamp = clock_.update(counter, sent);
      break;
    case Arrival::kLate:
      ++counters_.out_of_order;
      following_->stamp = clock_.to_host(counter);
      break;
  }
  if (verdict.arrival != Arrival::kLate) {
    newest_device_ns_ = following_->device_ns;
    following_->refused_before = std::exchange(refused_, 0);
  }
  ++counters_.packets;
  std::copy(datagram.payload.begin(), datagram.payload.end(), following_->bytes.begin());
  update_beam_table(packet, verdict);
  const bool late = verdict.arrival == Arrival::kLate;
  if (late || !has_held_) std::swap(held_, following_);
  has_following_ = has_held_;
  has_held_ = true;
}

/// Updates the properties that only the stream contains: an HDL-64E's calibration, a VLS-128's
/// firing cycle.
void SweepAssembler::update_beam_table(const Packet& packet, const ArrivalOrder::Verdict& verdict) {
  if (info_.calibrated_per_unit && calibration_source_ == CalibrationSource::kBuiltIn) {
    const int64_t period_us = packet_period(info_, info_.cycle, packet.dual()).count() / 1000;
    if (verdict.arrival != Arrival::kNext || verdict.delay_us > period_us * 3 / 2) {
      calibration_stream_.restart();
    }
    if (const auto streamed = calibration_stream_.add(packet.status_type, packet.product_id)) {
      calibration_ = *streamed;
      calibration_source_ = CalibrationSource::kStream;
      table_.rebuild(calibration_, table_.cycle);
    }
  }
  if (info_.model == Model::kVls128 && verdict.arrival == Arrival::kNext) {
    if (const auto cycle = cycle_estimator_.add(verdict.delay_us, packet.dual())) {
      table_.rebuild(calibration_, *cycle);
    }
  }
}

void SweepAssembler::finish() { finished_ = true; }

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
  const SequenceTiming timing{sequence_period(info_, table_.cycle).count(), table_.max_step};
  repair_held_azimuths(following, timing.period_ns);
  std::optional<FollowingPacket> next;
  if (following != nullptr && !following->after_clock_jump &&
      following->packet.azimuth[0] != kNoAzimuth) {
    next = FollowingPacket{following->packet.azimuth[0], following->device_ns - held_->device_ns};
  }
  plan_ = plan_firings(held_->packet, next, last_decoded_.step, timing);
  gap_from_.reset();
  lost_before_first_ = 0;
  bool lossy_jump = false;
  if (held_->after_clock_jump || !last_decoded_.valid) {
    cutter_.restart();
  } else {
    detect_gap(plan_.sequences[0], timing.period_ns);
    lossy_jump = plan_.sequences[0].after_jump && lost_before_first_ > 0;
  }
  for (size_t i = 0; i < plan_.count; ++i) {
    const PlannedSequence& sequence = plan_.sequences[i];
    cut_before_[i] =
        i == 0 && lossy_jump
            ? cutter_.process_lossy_jump(sequence.azimuth)
            : cutter_.process_sequence(sequence.azimuth, sequence.advance, sequence.after_jump);
  }
  if (cutter_.partial_turn()) add_steps(plan_, timing.period_ns, rotation_);
  last_decoded_ = {true, plan_.last().azimuth, plan_.last().step,
                   held_->device_ns + plan_.last().time_ns + timing.period_ns};
  next_sequence_ = 0;
  decoding_ = true;
}

/// Replaces azimuths of the held packet that cannot be the sensor's.
void SweepAssembler::repair_held_azimuths(const ReceivedPacket* following, int64_t period_ns) {
  const auto directly = [&](int64_t gap_ns) { return std::abs(gap_ns) <= period_ns / 2; };
  std::optional<int> before;
  std::optional<int> after;
  if (last_decoded_.valid && directly(held_->device_ns - last_decoded_.end_ns)) {
    before = last_decoded_.azimuth;
  }
  if (is_smooth(held_->packet, before.value_or(held_->packet.azimuth[0]), table_.max_step)) return;
  const int64_t end_ns = held_->device_ns + period_ns * held_->packet.sequences;
  if (following != nullptr && directly(following->device_ns - end_ns)) {
    after = following->packet.azimuth[0];
  }
  counters_.stray_azimuths += repair_azimuths(held_->packet, before, after, table_.max_step);
}

/// Classifies the gap between the last decoded packet and the held one: none, lost packets, or the
/// part of the turn that the sensor does not scan.
void SweepAssembler::detect_gap(PlannedSequence& first, int64_t period_ns) {
  const int64_t gap_ns = held_->device_ns - last_decoded_.end_ns;
  const int64_t packet_ns = period_ns * held_->packet.sequences;
  const int64_t pause_ns =
      cutter_.pause_within(last_decoded_.azimuth, gap_ns, period_ns, rotation_);
  const int64_t missing = std::max<int64_t>((gap_ns - pause_ns + packet_ns / 2) / packet_ns, 0);
  first.advance = azimuth_advance(last_decoded_.azimuth, first.azimuth);
  first.after_jump =
      first.advance > table_.max_step &&
      (missing == 0 || pause_ns > 0 || cutter_.is_known_jump(last_decoded_.azimuth, first.azimuth));
  lost_before_first_ = static_cast<uint32_t>(missing);
  // A refused packet has arrived: it is counted by its fault.
  const uint32_t lost = lost_before_first_ - std::min(lost_before_first_, held_->refused_before);
  counters_.network_lost += lost;
  const int64_t turned = last_decoded_.step * (gap_ns + period_ns) / period_ns;
  if (lost > 0 && turned >= kCentidegreesPerTurn) {
    ++counters_.outages;
    counters_.lost_in_outages += lost;
  }
  if (first.after_jump || missing == 0) return;

  const int64_t turns = (turned - first.advance + kCentidegreesPerTurn / 2) / kCentidegreesPerTurn;
  first.advance += static_cast<int32_t>(std::clamp<int64_t>(turns, 0, 1000) * kCentidegreesPerTurn);
  gap_from_ = last_decoded_.azimuth + last_decoded_.step;
}

/// True when a sweep is complete; false when the held packet is.
bool SweepAssembler::decode(Sweep& sweep) {
  const TimedPacket timed{PacketBytes(held_->bytes), held_->packet, held_->device_ns};
  while (next_sequence_ < plan_.count) {
    const size_t first = next_sequence_;
    const PlannedSequence& start = plan_.sequences[first];
    const int64_t start_ns = held_->device_ns + start.time_ns;
    if (writer_.is_open()) {
      if (first == 0 && lost_before_first_ > 0) {
        writer_.add_lost_packets(std::exchange(lost_before_first_, 0));
      }
      if (cut_before_[first] || !writer_.accepts(start_ns, options_.max_span)) {
        close();
        return true;
      }
      if (first == 0 && gap_from_) writer_.add_gap(*gap_from_, start.azimuth);
    } else {
      writer_.open(sweep, info_.lasers, start_ns, held_->stamp + Duration(start.time_ns));
    }
    size_t last = first + 1;
    while (last < plan_.count && !cut_before_[last]) ++last;
    writer_.append(table_, timed, plan_, first, last, options_.interpolate_azimuth);
    next_sequence_ = last;
  }
  return false;
}

void SweepAssembler::close() { writer_.close(clock_.state(), sweeps_++); }

}  // namespace infuse::velodyne
