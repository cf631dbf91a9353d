#include "fusion/monitoring/delay_ambiguity.hpp"

#include "fusion/monitoring/drift_detector.hpp"

namespace infuse::monitoring {
namespace {

constexpr double kMaxSteadyVariation = 0.05;  // share of the variance in a constant twist's square
constexpr double kMinTwist = 0.1;             // `drift_offset` per s; less is no motion

}  // namespace

void DelayAmbiguity::add(const Motion& motion) {
  constexpr DriftDetectorOptions kDefaults;
  geometry::Vector6 twist;
  twist << motion.angular_rate, motion.velocity;
  for (int k = 0; k < 6; ++k) twist(k) /= kDefaults.drift_offset[static_cast<size_t>(k)];
  mean_ += kOffsetFadeRate * (twist - mean_);
  mean_square_ += kOffsetFadeRate * (twist.squaredNorm() - mean_square_);
  weight_ += kOffsetFadeRate * (1 - weight_);
}

std::optional<Axis> DelayAmbiguity::axis() const {
  if (!(weight_ > 0)) return std::nullopt;
  const geometry::Vector6 mean = mean_ / weight_;
  const double square = mean_square_ / weight_;
  if (square < kMinTwist * kMinTwist) return std::nullopt;
  if (square - mean.squaredNorm() >= kMaxSteadyVariation * square) return std::nullopt;
  Eigen::Index axis = 0;
  mean.cwiseAbs().maxCoeff(&axis);
  return static_cast<Axis>(axis);
}

}  // namespace infuse::monitoring
