#include "fusion/watch/delay_ambiguity.hpp"

namespace infuse::watch {
namespace {

constexpr double kMemory = 1.0 / 30;
constexpr double kSteady = 0.05;   // share of the twist that changes, below which it is the same
constexpr double kStanding = 0.1;  // of a twist, by what matters in a second: nothing moves

}  // namespace

void DelayAmbiguity::add(const Motion& motion) {
  constexpr DriftTestOptions kMatters;
  geometry::Vector6 twist;
  twist << motion.angular_rate, motion.velocity;
  for (int k = 0; k < 6; ++k) twist(k) /= kMatters.drifted[static_cast<size_t>(k)];
  mean_ += kMemory * (twist - mean_);
  square_ += kMemory * (twist.squaredNorm() - square_);
  weight_ += kMemory * (1 - weight_);
}

std::optional<Axis> DelayAmbiguity::axis() const {
  if (!(weight_ > 0)) return std::nullopt;
  const geometry::Vector6 mean = mean_ / weight_;
  const double square = square_ / weight_;
  if (square < kStanding * kStanding) return std::nullopt;
  if (square - mean.squaredNorm() >= kSteady * square) return std::nullopt;
  Eigen::Index axis = 0;
  mean.cwiseAbs().maxCoeff(&axis);
  return static_cast<Axis>(axis);
}

}  // namespace infuse::watch
