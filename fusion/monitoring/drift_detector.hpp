#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::monitoring {

/// What the watch looks along: the six axes of a left perturbation of T_camera_lidar, how late the
/// camera's stamps are, and the rotations and time again with a wider look, which sees a drift that
/// is too far off for the narrow one.
enum class Axis : uint8_t {
  kRotationX,
  kRotationY,
  kRotationZ,
  kTranslationX,
  kTranslationY,
  kTranslationZ,
  kTime,
  kWideRotationX,
  kWideRotationY,
  kWideRotationZ,
  kWideTime
};
inline constexpr size_t kAxes = 11;

/// The far looks' own axes; the others as they are.
constexpr Axis base_axis(Axis axis) {
  if (axis < Axis::kWideRotationX) return axis;
  if (axis == Axis::kWideTime) return Axis::kTime;
  return static_cast<Axis>(static_cast<uint8_t>(axis) - static_cast<uint8_t>(Axis::kWideRotationX));
}

/// One number an axis.
using PerAxis = std::array<double, kAxes>;

/// What one picture says along every axis: the parabola of the dependence (nats) through the
/// present calibration and a step to both sides. All zero: the picture says nothing.
struct AxisEvaluation {
  PerAxis slope{};      ///< nats/rad, nats/m, nats/s, at the present calibration
  PerAxis curvature{};  ///< minus the second derivative; small or negative on a flank of the top
  PerAxis step{};       ///< rad, m, s; how far was looked

  /// What the look is worth, as the inverse of a variance on an unknown scale: the bend, or so much
  /// that the top lies within the step.
  double information(size_t axis) const;
  /// Where the top lies, seen from the present calibration.
  double offset(size_t axis) const;
};

/// Settings of the sequential test. Angles in rad, lengths in m, times in s.
struct DriftDetectorOptions {
  /// Offsets up to which the calibration counts as kept: what the measure's own bias may be.
  PerAxis tolerated_offset{1.6e-3, 1.6e-3, 1.6e-3, 0.015,  0.015, 0.05,
                           0.03,   8.7e-3, 8.7e-3, 8.7e-3, 0.08};
  /// Offsets that are to be found soon.
  PerAxis drift_offset{7e-3, 7e-3, 7e-3, 0.05, 0.05, 0.15, 0.10, 0.026, 0.026, 0.026, 0.2};
  double false_alarm_hours = 1000;  ///< mean time between false alarms at `evaluations_per_second`
  double evaluations_per_second = 2.5;       ///< how often `add` is called at most
  double suspicion_threshold = 4;            ///< evidence, nats, at which drift is suspected
  double max_evidence_per_evaluation = 1.7;  ///< nats; no single picture brings more evidence
  int warm_up = 12;  ///< looks before anything is said: the scale of noise is learned meanwhile

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;

  /// Evidence (nats) at which drift is certain: the mean time between false alarms of a CUSUM of
  /// log-likelihood ratios is at least e^h looks (Lorden 1971), of n of them side by side e^h ÷ n:
  /// here two an axis.
  double confirmation_threshold() const;
};

/// Sequential test whether a calibration still holds: for each axis and sign a CUSUM (Page 1954) of
/// the log-likelihood ratio between an offset of `drifted` and one of `kept`,
///   S ← max(0, S + (θ₁ − θ₀) ÷ κ · (± s − ½ (θ₀ + θ₁) b)),
/// s and b the slope and bend of a look. Where ½ (θ₀ + θ₁) is half a step, the bracket is how much
/// the dependence gains by that step: a calibration that is a step off stands on a flank, where
/// the bend alone says little, and the step leads to the top. κ, the variance of the offset s ÷ b
/// in units of 1 ÷ b, is learned from differences between means of blocks of looks, so that neither
/// a constant offset nor correlation from picture to picture is taken for less noise than there is.
///
/// Far looks and those along the optical axis and time mostly reach the foot of the top, where
/// slope and bend are noise: for them b is the look's information, which is never less than puts
/// the top within the step.
class DriftDetector {
 public:
  /// `options.invalid()` must be empty.
  explicit DriftDetector(const DriftDetectorOptions& options);

  /// Takes one look. Looks must be of different places: a standing vehicle says all it can once.
  void add(const AxisEvaluation& evaluation);

  /// The calibration was changed: evidence starts anew, the scale of noise is kept.
  void restart();

  /// Evidence for drift along an axis, nats, of the stronger sign.
  double evidence(Axis axis) const;
  /// The axis with the most evidence.
  Axis strongest_axis() const;
  /// The near or the far look along an axis, whichever has more evidence.
  Axis strongest_variant(Axis axis) const;
  bool warmed_up() const { return evaluations_ >= options_.warm_up; }
  bool suspected() const {
    return warmed_up() && evidence(strongest_axis()) >= options_.suspicion_threshold;
  }
  bool confirmed() const {
    return warmed_up() && evidence(strongest_axis()) >= confirmation_threshold_;
  }
  int evaluations() const { return evaluations_; }

  /// The mean offset, and its standard deviation: where drift is suspected along the axis, of the
  /// looks since its evidence began, when the calibration presumably changed; else of all. Looks
  /// fade by 1/30 each. 0 and infinity where nothing is known.
  double offset(Axis axis) const;
  double sigma(Axis axis) const;

 private:
  /// Mean offset, fading.
  struct Mean {
    double sum = 0, weight = 0;
    void add(double slope, double information);
  };
  /// Evidence for an offset of one sign, and the offsets since it began.
  struct Cusum {
    double evidence = 0;
    Mean mean;
  };
  /// What is known of one axis.
  struct AxisState {
    Cusum positive, negative;  // for a positive and a negative offset
    Mean overall;
    double block = 0, block_weight = 0;
    double previous_block = 0, previous_block_weight = 0;  // the block before
    double noise = 0, noise_weight = 0;                    // κ: sum and count, fading
  };
  const Mean& reported_mean(const AxisState& track) const;
  double noise_variance(const AxisState& track) const;
  void update_noise(AxisState& track, double offset, double information);

  DriftDetectorOptions options_;
  double confirmation_threshold_;
  std::array<AxisState, kAxes> axes_;
  int evaluations_ = 0;
};

/// "rotation about x", "translation along z", "time".
const char* to_string(Axis axis);

}  // namespace infuse::monitoring
