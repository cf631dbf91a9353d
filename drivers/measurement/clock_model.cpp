#include "drivers/measurement/clock_model.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "drivers/measurement/lower_envelope.hpp"

namespace infuse {
namespace {

constexpr Duration kZero = Duration::zero();

/// Limit of accepted stamps: beyond any real time (±126 years), small enough that no arithmetic
/// here overflows.
constexpr int64_t kMaxAbsStampNs = 4'000'000'000'000'000'000;

/// A part of the window is risen if its smallest delay lies further above the envelope than its
/// mean delay lies above its smallest, plus kMinRiseNs. One risen part makes the envelope doubtful,
/// kMinRisenParts in a row make it out of date.
constexpr uint32_t kMinSamplesForRise = 8;
constexpr double kMinRiseNs = 100'000;
constexpr uint32_t kMinRisenParts = 3;

/// Evidence (nats) for a jump against delays of the known mean, if these are exponentially
/// distributed: n samples that lie d above the envelope by chance have probability
/// e^(-n d / mean).
constexpr double kMinJumpEvidence = 25;

Stamp clamp_stamp(Stamp stamp) {
  return Stamp::from_ns(std::clamp(stamp.ns(), -kMaxAbsStampNs, kMaxAbsStampNs));
}

double as_double(Duration span) { return static_cast<double>(span.count()); }

Duration rounded(double ns) { return Duration(std::llround(ns)); }

}  // namespace

std::optional<std::string> ClockModelOptions::invalid() const {
  constexpr Duration kDay = std::chrono::hours(24);
  if (modulo < kZero || modulo > kDay) return "modulo must be between 0 (none) and a day";
  if (min_delay < kZero || min_delay > kDay) {
    return "min_delay must be between 0 and a day";
  }
  if (!(max_skew_ppm > 0) || max_skew_ppm > 10'000) {
    return "max_skew_ppm must be more than 0 and at most 10000";
  }
  if (window < std::chrono::seconds(1) || window > kDay) {
    return "window must be between a second and a day";
  }
  if (settling_time < kZero || settling_time > window)
    return "settling_time must be between 0 and window";
  if (jump_threshold <= kZero || jump_threshold > max_delay) {
    return "jump_threshold must be more than 0 and at most max_delay";
  }
  if (jump_confirmation < kZero || jump_confirmation > kDay) {
    return "jump_confirmation must be between 0 and a day";
  }
  if (max_delay > kDay) return "max_delay must be at most a day";
  if (modulo > kZero && max_delay >= modulo / 2)
    return "max_delay must be less than half of modulo";
  if (hour_tolerance < kZero || hour_tolerance > kDay) {
    return "hour_tolerance must be between 0 and a day";
  }
  return std::nullopt;
}

ClockModel::ClockModel(const ClockModelOptions& options) : options_(options) {
  if (const auto wrong = options.invalid()) throw std::invalid_argument(*wrong);
  state_.source = ClockState::Source::kHost;
  state_.reason = "no sample yet";
}

Stamp ClockModel::update(Duration device, Stamp host) {
  const Stamp sent = clamp_stamp(host) - options_.min_delay;
  if (!started_) {
    const Stamp placed = unwrap(device, sent);
    restart(placed, sent - placed);
  }
  const Stamp unwrapped = unwrap(device, sent - offset_at(last_device_));
  const Stamp mapped = unwrapped + offset_at(unwrapped);
  const Duration delay = sent - mapped;

  const bool starting = part_count_ == 0;
  const Duration min_delay = starting ? -options_.max_delay : -options_.jump_threshold;
  if (delay < min_delay || delay > options_.jump_threshold) {
    const bool jumped = detect_jump(device, sent);
    const bool plausible = delay > kZero && delay <= options_.max_delay;
    update_state(plausible && !jumped);
    return plausible && !jumped ? mapped : sent;
  }
  jump_candidate_ = JumpCandidate();
  add_sample(unwrapped, sent);
  update_state(true);
  return std::min(unwrapped + offset_at(unwrapped), sent);
}

Stamp ClockModel::to_host(Duration device) const {
  if (!started_) return Stamp::from_ns(device.count());
  const Stamp unwrapped = unwrap(device, last_device_);
  return unwrapped + offset_at(unwrapped);
}

Duration ClockModel::offset_at(Stamp device) const {
  return line_.offset + rounded(line_.slope * as_double(device - line_.device));
}

/// Returns the time of the wrapping counter that is nearest to `expected`.
Stamp ClockModel::unwrap(Duration device, Stamp expected) const {
  const Stamp counted = clamp_stamp(Stamp::from_ns(device.count()));
  if (options_.modulo == kZero) return counted;
  const Duration ahead = expected - counted;
  int64_t turns = ahead / options_.modulo;
  const Duration rest = ahead - turns * options_.modulo;
  if (rest > options_.modulo / 2) ++turns;
  if (rest < -options_.modulo / 2) --turns;
  return counted + turns * options_.modulo;
}

void ClockModel::restart(Stamp device, Duration offset) {
  started_ = true;
  line_ = Line{.device = device, .offset = offset, .slope = 0};
  first_device_ = device;
  last_device_ = device - Duration(1);
  samples_ = 0;
  skew_at_limit_ = false;
  risen_parts_ = 0;
  part_ = Part{.begin = device};
  oldest_part_ = 0;
  part_count_ = 0;
  jump_candidate_ = JumpCandidate();
  state_.jitter = kZero;
}

bool ClockModel::detect_jump(Duration device, Stamp host) {
  const Duration known =
      jump_candidate_.count > 0 ? jump_candidate_.offset : offset_at(last_device_);
  const Stamp unwrapped = unwrap(device, host - known);
  const Duration offset = host - unwrapped;
  const bool agrees =
      jump_candidate_.count > 0 && host >= jump_candidate_.since &&
      distance_between(host, unwrapped + jump_candidate_.offset) <= options_.jump_threshold;
  if (!agrees) jump_candidate_ = JumpCandidate{.count = 0, .since = host, .offset = offset};
  ++jump_candidate_.count;
  jump_candidate_.offset = std::min(jump_candidate_.offset, offset);
  if (jump_candidate_.count < kMinJumpSamples ||
      host - jump_candidate_.since < options_.jump_confirmation || may_be_delay()) {
    return false;
  }
  ++state_.jumps;
  hour_confirmed_ = false;
  const Stamp placed = unwrap(device, host);
  restart(placed, (host - placed) + (jump_candidate_.offset - offset));
  return true;
}

bool ClockModel::may_be_delay() const {
  const double rise = as_double(jump_candidate_.offset - offset_at(last_device_));
  const double latest = part_.samples > 0 ? part_.delay_sum_ns / part_.samples : 0;
  const double mean = std::max(as_double(state_.jitter), latest);
  return rise > 0 && jump_candidate_.count * rise < kMinJumpEvidence * mean;
}

void ClockModel::add_sample(Stamp device, Stamp host) {
  if (device <= last_device_)
    return;  // out of order: a late sample carries no information about the envelope
  last_device_ = device;
  ++samples_;
  if (part_.samples > 0 && device - part_.begin >= options_.window / kParts) {
    complete_part();
    part_ = Part{.begin = device};
  }
  const Duration offset = host - device;
  const Duration delay = offset - offset_at(device);
  if (delay < kZero) line_.offset += delay;
  // With the slope subtracted, the smallest offset of the part is its smallest delay.
  const double rise = as_double(offset - part_.offset);
  if (part_.samples == 0 || rise < line_.slope * as_double(device - part_.device)) {
    part_.device = device;
    part_.offset = offset;
  }
  ++part_.samples;
  part_.delay_sum_ns += std::max(0.0, as_double(delay));
}

void ClockModel::complete_part() {
  const double min_delay = as_double(part_.offset - offset_at(part_.device));
  const double mean = part_.delay_sum_ns / part_.samples;
  const bool rises =
      part_.samples >= kMinSamplesForRise && min_delay > (mean - min_delay) + kMinRiseNs;
  risen_parts_ = rises ? risen_parts_ + 1 : 0;
  if (part_count_ == kParts) drop_oldest_part();
  parts_[(oldest_part_ + part_count_) % kParts] = part_;
  ++part_count_;
  while (part_.device - parts_[oldest_part_].device > options_.window) {
    drop_oldest_part();
  }
  while (risen_parts_ >= kMinRisenParts && part_count_ > kMinRisenParts) drop_oldest_part();
  fit();
}

void ClockModel::drop_oldest_part() {
  oldest_part_ = (oldest_part_ + 1) % kParts;
  --part_count_;
}

void ClockModel::fit() {
  std::array<EnvelopePoint, kParts> points;
  double delay_sum_ns = 0;
  uint64_t samples = 0;
  for (size_t i = 0; i < part_count_; ++i) {
    const Part& part = parts_[(oldest_part_ + i) % kParts];
    points[i] = {.x = as_double(part.device - part_.device),
                 .y = as_double(part.offset - part_.offset)};
    delay_sum_ns += part.delay_sum_ns;
    samples += part.samples;
  }
  const double max_slope = part_count_ < kMinPartsForSkew ? 0 : options_.max_skew_ppm * 1e-6;
  const EnvelopeLine line = lower_envelope(std::span(points).first(part_count_), max_slope);
  line_ = Line{.device = part_.device,
               .offset = part_.offset + rounded(line.intercept),
               .slope = line.slope};
  skew_at_limit_ = max_slope > 0 && std::abs(line.slope) >= max_slope;
  state_.jitter = rounded(delay_sum_ns / static_cast<double>(samples));
}

void ClockModel::update_state(bool model_holds) {
  state_.offset = offset_at(last_device_);
  state_.skew_ppm = (1 / (1 + line_.slope) - 1) * 1e6;
  const bool can_agree =
      options_.modulo > kZero || options_.synchronised != ClockState::Source::kTopOfHour;
  const bool agrees =
      can_agree && (hour_confirmed_ || std::chrono::abs(state_.offset) <= options_.hour_tolerance);
  state_.source = agrees ? options_.synchronised : ClockState::Source::kPowerUp;
  state_.reason = "";
  if (!model_holds) {
    state_.reason = "device time disagrees with arrival times: a jump or a bad packet";
  } else if (samples_ < options_.min_samples || part_count_ < kMinPartsForSkew ||
             last_device_ - first_device_ < options_.settling_time) {
    state_.reason = state_.jumps > 0 ? "not settled after a jump" : "not settled after the start";
  } else if (skew_at_limit_) {
    state_.reason = "skew at its limit: one of the clocks is faulty or was stepped";
  } else if (risen_parts_ > 0) {
    state_.reason = "minimum transport delay has risen: a small clock jump, or a busy network";
  }
  state_.trusted = *state_.reason == '\0';
}

}  // namespace infuse
