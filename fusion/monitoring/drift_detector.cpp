#include "fusion/monitoring/drift_detector.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace infuse::monitoring {
namespace {

constexpr int kBlockSize = 4;  // evaluations whose mean is compared with the next block's
constexpr double kNoiseFadeRate = kOffsetFadeRate / 2;  // fading of the noise per block
constexpr double kPriorBlocks = 2;                      // weight of the prior noise
constexpr double kPriorNoise = 0.006;  // κ on simulated streets and a third (decision 17)
constexpr double kMaxNoiseRatio = 9;   // of a block's κ to the mean: 99.7 % of χ² with 1 degree
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
      return "0 <= tolerated_offset < drift_offset must hold";
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

double DriftDetector::noise_variance(const AxisState& state) const {
  return (state.noise + kPriorBlocks * kPriorNoise) / (state.noise_weight + kPriorBlocks);
}

void DriftDetector::update_noise(AxisState& state, double offset, double information) {
  state.block += information * offset;
  state.block_weight += information;
  if ((evaluations_ + 1) % kBlockSize != 0) return;
  if (state.previous_block_weight > 0 && state.block_weight > 0) {
    // Var(a − b) = κ (1/wa + 1/wb), of blocks that are nearly independent.
    const double apart =
        state.block / state.block_weight - state.previous_block / state.previous_block_weight;
    const double shared = 1 / state.block_weight + 1 / state.previous_block_weight;
    const double noise = std::min(apart * apart / shared, kMaxNoiseRatio * noise_variance(state));
    state.noise += noise - kNoiseFadeRate * state.noise;
    state.noise_weight += 1 - kNoiseFadeRate * state.noise_weight;
  }
  state.previous_block = state.block;
  state.previous_block_weight = state.block_weight;
  state.block = state.block_weight = 0;
}

void DriftDetector::Mean::add(double slope, double information) {
  sum += slope - kOffsetFadeRate * sum;
  weight += information - kOffsetFadeRate * weight;
}

void DriftDetector::add(const AxisEvaluation& evaluation) {
  for (size_t k = 0; k < kAxes; ++k) {
    AxisState& state = axes_[k];
    const double w = evaluation.information(k);
    update_noise(state, evaluation.offset(k), w);
    state.overall.add(evaluation.slope[k], w);
    const double offset_difference = options_.drift_offset[k] - options_.tolerated_offset[k];
    const double middle = 0.5 * (options_.drift_offset[k] + options_.tolerated_offset[k]);
    const double scale = kEvaluationWeight * offset_difference / noise_variance(state);
    const double curvature = has_reliable_curvature(k) ? evaluation.curvature[k] : w;
    const auto step = [&](Cusum& run, double sign) {
      const double ratio = scale * (sign * evaluation.slope[k] - middle * curvature);
      run.evidence += std::clamp(ratio, -options_.max_evidence_per_evaluation,
                                 options_.max_evidence_per_evaluation);
      run.mean.add(evaluation.slope[k], w);
      ++run.evaluations;
      if (run.evidence <= 0) run = {};
    };
    step(state.positive, 1);
    step(state.negative, -1);
  }
  ++evaluations_;
  ++since_restart_;
}

void DriftDetector::restart() {
  since_restart_ = 0;
  for (AxisState& state : axes_) {
    state.positive = state.negative = {};
    state.overall = {};
    state.block = state.block_weight = state.previous_block = state.previous_block_weight = 0;
  }
}

double DriftDetector::evidence(Axis axis) const {
  const AxisState& state = axes_[static_cast<size_t>(axis)];
  return std::max(state.positive.evidence, state.negative.evidence);
}

Axis DriftDetector::strongest_axis() const {
  Axis best = Axis::kRotationX;
  for (size_t k = 1; k < kAxes; ++k) {
    if (evidence(static_cast<Axis>(k)) > evidence(best)) best = static_cast<Axis>(k);
  }
  return best;
}

int DriftDetector::evaluations_since_onset() const {
  const AxisState& state = axes_[static_cast<size_t>(strongest_axis())];
  return state.positive.evidence > state.negative.evidence ? state.positive.evaluations
                                                           : state.negative.evaluations;
}

double DriftDetector::noise() const {
  double sum = 0;
  for (size_t k = 0; k < 6; ++k) sum += noise_variance(axes_[k]);
  return sum / 6 / kEvaluationWeight;
}

Axis DriftDetector::strongest_variant(Axis axis) const {
  Axis best = axis;
  for (size_t k = 0; k < kAxes; ++k) {
    const auto other = static_cast<Axis>(k);
    if (base_axis(other) == axis && evidence(other) > evidence(best)) best = other;
  }
  return best;
}

const DriftDetector::Mean& DriftDetector::reported_mean(const AxisState& state) const {
  const Cusum& stronger =
      state.positive.evidence > state.negative.evidence ? state.positive : state.negative;
  return stronger.evidence >= options_.suspicion_threshold ? stronger.mean : state.overall;
}

double DriftDetector::offset(Axis axis) const {
  const Mean& mean = reported_mean(axes_[static_cast<size_t>(axis)]);
  return mean.weight > 0 ? mean.sum / mean.weight : 0;
}

double DriftDetector::sigma(Axis axis) const {
  const AxisState& state = axes_[static_cast<size_t>(axis)];
  const Mean& mean = reported_mean(state);
  return mean.weight > 0 ? std::sqrt(noise_variance(state) / mean.weight)
                         : std::numeric_limits<double>::infinity();
}

DriftVerdict DriftDetector::verdict() const {
  DriftVerdict verdict;
  verdict.drift = !warmed_up()  ? Drift::kLearning
                  : confirmed() ? Drift::kConfirmed
                  : suspected() ? Drift::kSuspected
                                : Drift::kHolds;
  verdict.axis = base_axis(strongest_axis());
  verdict.evidence = evidence(strongest_axis());
  for (size_t k = 0; k < kAxes; ++k) {
    const Axis other = base_axis(static_cast<Axis>(k));
    if (other == verdict.axis || evidence(static_cast<Axis>(k)) <= verdict.runner_up_evidence) {
      continue;
    }
    verdict.runner_up = other;
    verdict.runner_up_evidence = evidence(static_cast<Axis>(k));
  }
  verdict.threshold = confirmation_threshold_;
  for (int k = 0; k < 6; ++k) {
    // The maximum lies at +d: the present calibration is off by −d.
    const Axis variant = strongest_variant(static_cast<Axis>(k));
    verdict.offset(k) = -offset(variant);
    verdict.sigma(k) = sigma(variant);
  }
  verdict.delay = offset(strongest_variant(Axis::kTime));
  return verdict;
}

}  // namespace infuse::monitoring
