#include "fusion/monitoring/drift_detector.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace infuse::monitoring {
namespace {

constexpr int kBlockSize = 4;           // evaluations whose mean is compared with the next block's
constexpr double kFadeRate = 1.0 / 30;  // fading of the mean offset per evaluation
constexpr double kNoiseFadeRate = 1.0 / 60;  // fading of the noise per block
constexpr double kPriorBlocks = 2;           // weight of the prior noise
constexpr double kPriorNoise = 0.006;        // κ on simulated streets, and a third more
constexpr double kMaxNoiseRatio = 9;         // maximum of a block's κ, times the mean so far
/// Weight of an evaluation: those of one street share a bias for longer than a block.
constexpr double kEvaluationWeight = 0.7;

/// True for axes whose steps stay on the flanks of the peak.
bool has_reliable_curvature(size_t axis) {
  return axis <= static_cast<size_t>(Axis::kTranslationY);
}

}  // namespace

std::optional<std::string> DriftDetectorOptions::invalid() const {
  for (size_t k = 0; k < kAxes; ++k) {
    if (!(tolerated_offset[k] >= 0) || !(drift_offset[k] > tolerated_offset[k]))
      return "0 <= kept < drifted must hold";
  }
  if (!(false_alarm_hours > 0) || !(evaluations_per_second > 0)) {
    return "false_alarm_hours and evaluations_per_second must be positive";
  }
  if (!(suspicion_threshold > 0) || suspicion_threshold >= confirmation_threshold())
    return "suspicion_threshold must be positive and below the confirmation threshold";
  if (!(max_evidence_per_evaluation > 0)) return "max_evidence_per_evaluation must be positive";
  if (warm_up < 2 * kBlockSize) return "warm_up must be at least 8";
  return std::nullopt;
}

double AxisEvaluation::information(size_t axis) const {
  const double min_information = step[axis] > 0 ? std::abs(slope[axis]) / step[axis] : 0;
  return std::max(curvature[axis], min_information);
}

double AxisEvaluation::offset(size_t axis) const {
  const double weight = information(axis);
  return weight > 0 ? slope[axis] / weight : 0;
}

double DriftDetectorOptions::confirmation_threshold() const {
  return std::log(2.0 * kAxes * false_alarm_hours * 3600 * evaluations_per_second);
}

DriftDetector::DriftDetector(const DriftDetectorOptions& options)
    : options_(options), confirmation_threshold_(options.confirmation_threshold()) {}

double DriftDetector::noise_variance(const AxisState& track) const {
  return (track.noise + kPriorBlocks * kPriorNoise) / (track.noise_weight + kPriorBlocks);
}

void DriftDetector::update_noise(AxisState& track, double offset, double information) {
  track.block += information * offset;
  track.block_weight += information;
  if ((evaluations_ + 1) % kBlockSize != 0) return;
  if (track.previous_block_weight > 0 && track.block_weight > 0) {
    // Var(a − b) = κ (1/wa + 1/wb), of blocks that are nearly independent.
    const double apart =
        track.block / track.block_weight - track.previous_block / track.previous_block_weight;
    const double shared = 1 / track.block_weight + 1 / track.previous_block_weight;
    const double noise = std::min(apart * apart / shared, kMaxNoiseRatio * noise_variance(track));
    track.noise += noise - kNoiseFadeRate * track.noise;
    track.noise_weight += 1 - kNoiseFadeRate * track.noise_weight;
  }
  track.previous_block = track.block;
  track.previous_block_weight = track.block_weight;
  track.block = track.block_weight = 0;
}

void DriftDetector::Mean::add(double slope, double information) {
  sum += slope - kFadeRate * sum;
  weight += information - kFadeRate * weight;
}

void DriftDetector::add(const AxisEvaluation& look) {
  for (size_t k = 0; k < kAxes; ++k) {
    AxisState& track = axes_[k];
    const double w = look.information(k);
    update_noise(track, look.offset(k), w);
    track.overall.add(look.slope[k], w);
    const double offset_difference = options_.drift_offset[k] - options_.tolerated_offset[k];
    const double middle = 0.5 * (options_.drift_offset[k] + options_.tolerated_offset[k]);
    const double scale = kEvaluationWeight * offset_difference / noise_variance(track);
    const double curvature = has_reliable_curvature(k) ? look.curvature[k] : w;
    const auto step = [&](Cusum& run, double sign) {
      const double ratio = scale * (sign * look.slope[k] - middle * curvature);
      run.evidence += std::clamp(ratio, -options_.max_evidence_per_evaluation,
                                 options_.max_evidence_per_evaluation);
      run.mean.add(look.slope[k], w);
      if (run.evidence <= 0) run = {};
    };
    step(track.positive, 1);
    step(track.negative, -1);
  }
  ++evaluations_;
}

void DriftDetector::restart() {
  for (AxisState& track : axes_) {
    track.positive = track.negative = {};
    track.overall = {};
    track.block = track.block_weight = track.previous_block = track.previous_block_weight = 0;
  }
}

double DriftDetector::evidence(Axis axis) const {
  const AxisState& track = axes_[static_cast<size_t>(axis)];
  return std::max(track.positive.evidence, track.negative.evidence);
}

Axis DriftDetector::strongest_axis() const {
  Axis best = Axis::kRotationX;
  for (size_t k = 1; k < kAxes; ++k) {
    if (evidence(static_cast<Axis>(k)) > evidence(best)) best = static_cast<Axis>(k);
  }
  return best;
}

Axis DriftDetector::strongest_variant(Axis axis) const {
  Axis best = axis;
  for (size_t k = 0; k < kAxes; ++k) {
    const auto other = static_cast<Axis>(k);
    if (base_axis(other) == axis && evidence(other) > evidence(best)) best = other;
  }
  return best;
}

const DriftDetector::Mean& DriftDetector::reported_mean(const AxisState& track) const {
  const Cusum& stronger =
      track.positive.evidence > track.negative.evidence ? track.positive : track.negative;
  return stronger.evidence >= options_.suspicion_threshold ? stronger.mean : track.overall;
}

double DriftDetector::offset(Axis axis) const {
  const Mean& mean = reported_mean(axes_[static_cast<size_t>(axis)]);
  return mean.weight > 0 ? mean.sum / mean.weight : 0;
}

double DriftDetector::sigma(Axis axis) const {
  const AxisState& track = axes_[static_cast<size_t>(axis)];
  const Mean& mean = reported_mean(track);
  return mean.weight > 0 ? std::sqrt(noise_variance(track) / mean.weight)
                         : std::numeric_limits<double>::infinity();
}

const char* to_string(Axis axis) {
  constexpr std::array<const char*, 7> kNames = {"rotation about x",
                                                 "rotation about y",
                                                 "rotation about z",
                                                 "translation along x",
                                                 "translation along y",
                                                 "translation along z",
                                                 "time"};
  return kNames[static_cast<size_t>(base_axis(axis))];
}

}  // namespace infuse::monitoring
