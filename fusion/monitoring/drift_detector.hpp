#pragma once

#include <array>
#include <optional>
#include <string>

#include "fusion/monitoring/axis.hpp"
#include "fusion/monitoring/drift_verdict.hpp"

namespace infuse::monitoring {

/// One number per axis.
using PerAxis = std::array<double, kAxes>;

/// Evaluation of one image along every axis: the parabola of the dependence (nats) through the
/// present calibration and one step to both sides. All zero: no information.
struct AxisEvaluation {
  PerAxis slope{};      ///< nats/rad, nats/m, nats/s, at the present calibration
  PerAxis curvature{};  ///< minus the second derivative; small or negative on a flank
  PerAxis step{};       ///< rad, m, s; step of the evaluation

  /// Returns the information of the evaluation, the inverse of a variance on an unknown scale: the
  /// curvature, but at least so much that the maximum lies within the step.
  double information(size_t axis) const;
  /// Returns the offset of the maximum from the present calibration.
  double offset(size_t axis) const;
};

/// Fading of means over evaluations, per evaluation.
inline constexpr double kOffsetFadeRate = 1.0 / 30;

/// Settings of the sequential test. Angles in rad, lengths in m, times in s.
struct DriftDetectorOptions {
  /// Offsets up to which the calibration holds: possible bias of the measure.
  PerAxis tolerated_offset{1.6e-3, 1.6e-3, 1.6e-3, 0.015,  0.015,  0.05,  0.03,  7.1e-3, 7.1e-3,
                           7.1e-3, 0.08,   0.0175, 0.0175, 0.0175, 0.035, 0.035, 0.035};
  /// Offsets that are to be detected soon.
  PerAxis drift_offset{7e-3,   7e-3, 7e-3,   0.05,   0.05,   0.15,  0.10,  0.0214, 0.0214,
                       0.0214, 0.2,  0.0524, 0.0524, 0.0524, 0.105, 0.105, 0.105};
  double false_alarm_hours = 1000;  ///< mean time between false alarms at `evaluations_per_second`
  /// Maximum rate of `add`, derived from `MonitorOptions::min_interval` at images of 10 Hz.
  double evaluations_per_second = 2.5;
  double suspicion_threshold = 4;  ///< nats of a suspected drift: of one axis at most one in 55
                                   ///< evaluations by chance (Lorden 1971)
  double max_evidence_per_evaluation = 1.7;  ///< maximum evidence of one image, nats
  int warm_up = 12;  ///< evaluations before anything is reported: the noise is learned

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;

  /// Returns the evidence (nats) of a confirmed drift: the mean time between false alarms of a
  /// CUSUM of log-likelihood ratios is at least e^h evaluations (Lorden 1971), of n of them in
  /// parallel e^h ÷ n; here two per axis.
  double confirmation_threshold() const;
};

/// Sequential test of a calibration: for each axis and sign a CUSUM (Page 1954) of the
/// log-likelihood ratio between an offset θ₁ of `drift_offset` and one θ₀ of `tolerated_offset`,
///   S ← max(0, S + (θ₁ − θ₀) ÷ κ · (± s − ½ (θ₀ + θ₁) b)),
/// s and b the slope and curvature of an evaluation. If ½ (θ₀ + θ₁) is half a step, the bracket is
/// the gain of the dependence by that step: a calibration that is one step off lies on a flank,
/// where the curvature alone says little, and the step leads to the maximum. κ, the variance of the
/// offset s ÷ b in units of 1 ÷ b, is learned from differences between means of blocks of
/// evaluations, so that neither a constant offset nor correlation between images reduces the
/// estimated noise.
///
/// Wide evaluations and those along the optical axis and time mostly reach the foot of the peak,
/// where slope and curvature are noise: for them b is `AxisEvaluation::information`, which keeps
/// the maximum within the step.
class DriftDetector {
 public:
  /// `options.invalid()` must be empty.
  explicit DriftDetector(const DriftDetectorOptions& options);

  /// Adds one evaluation. Evaluations must be of different places: a standing vehicle has no new
  /// information.
  void add(const AxisEvaluation& evaluation);

  /// Restarts the evidence after a change of the calibration; keeps the noise.
  void restart();

  /// Returns the evidence for drift along an axis, nats, of the stronger sign.
  double evidence(Axis axis) const;
  /// Returns the axis with the most evidence.
  Axis strongest_axis() const;
  /// Returns the narrow or the wide variant of an axis, whichever has more evidence.
  Axis strongest_variant(Axis axis) const;
  /// Number of evaluations since the beginning or the last `restart`.
  int evaluations_since_restart() const { return since_restart_; }
  bool warmed_up() const { return evaluations_ >= options_.warm_up; }
  bool suspected() const {
    return warmed_up() && evidence(strongest_axis()) >= options_.suspicion_threshold;
  }
  bool confirmed() const {
    return warmed_up() && evidence(strongest_axis()) >= confirmation_threshold_;
  }
  int evaluations() const { return evaluations_; }

  /// Number of evaluations since the evidence along the strongest axis began: presumably since the
  /// calibration changed.
  int evaluations_since_onset() const;
  /// Nats by which a difference of dependence, summed over evaluations, is divided to be a
  /// log-likelihood ratio: the mean κ of the pose's axes.
  double noise() const;
  double confirmation_threshold() const { return confirmation_threshold_; }

  /// Returns what the evaluations say: all of a verdict but the fault of the camera, and whether a
  /// delay can be separated.
  DriftVerdict verdict() const;

  /// Mean offset and its standard deviation: if drift is suspected along the axis, over the
  /// evaluations since its evidence began, when the calibration presumably changed; otherwise over
  /// all. Older evaluations fade by 1/30 each. 0 and infinity without evaluations.
  double offset(Axis axis) const;
  double sigma(Axis axis) const;

 private:
  /// Fading mean of offsets.
  struct Mean {
    double sum = 0, weight = 0;
    void add(double slope, double information);
  };
  /// Evidence for an offset of one sign, and the mean offset since it began.
  struct Cusum {
    double evidence = 0;
    int evaluations = 0;
    Mean mean;
  };
  /// State of one axis.
  struct AxisState {
    Cusum positive, negative;  // evidence for a positive and a negative offset
    Mean overall;
    double block = 0, block_weight = 0;
    double previous_block = 0, previous_block_weight = 0;  // the block before
    double noise = 0, noise_weight = 0;                    // κ: sum and count, fading
  };
  const Mean& reported_mean(const AxisState& state) const;
  double noise_variance(const AxisState& state) const;
  void update_noise(AxisState& state, double offset, double information);

  DriftDetectorOptions options_;
  double confirmation_threshold_;
  std::array<AxisState, kAxes> axes_;
  int evaluations_ = 0;
  int since_restart_ = 0;
};

}  // namespace infuse::monitoring
