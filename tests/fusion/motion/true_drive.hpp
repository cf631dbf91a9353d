#pragma once

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "drivers/measurement/vehicle_samples.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::motion {

/// Simulated drive with known truth: body twist as a function of time (s), integrated in steps of
/// half a millisecond. `unseen` is a part of the motion that neither wheels nor gyros measure.
class TrueDrive {
 public:
  using TwistFunction = std::function<geometry::Vector6(double)>;

  TrueDrive(double seconds, TwistFunction twist, TwistFunction unseen = {})
      : twist_(std::move(twist)), unseen_(std::move(unseen)) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    for (double t = 0; t <= seconds; t += kStep) {
      poses_.push_back(T);
      T = T * geometry::exp(kStep * motion(t + kStep / 2));
    }
  }

  geometry::Vector6 twist(double t) const { return twist_(t); }
  double seconds() const { return kStep * static_cast<double>(poses_.size() - 1); }

  Eigen::Isometry3d pose(double t) const {
    const auto i = std::min(static_cast<size_t>(t / kStep), poses_.size() - 1);
    const double rest = t - kStep * static_cast<double>(i);
    return poses_[i] * geometry::exp(rest * motion(t - rest / 2));
  }

  /// Noiseless wheel speeds of a vehicle with the default dimensions.
  WheelOdometry wheels(double t, double wheelbase = 2.7, double track = 1.55) const {
    const geometry::Vector6 now = twist_(t);
    WheelOdometry sample;
    sample.stamp = Stamp::from_ns(static_cast<int64_t>(std::llround(t * 1e9)));
    for (size_t i = 0; i < 4; ++i) {
      const double along = now[3] - now[2] * (i % 2 == 0 ? track / 2 : -track / 2);
      const double across = i < 2 ? now[2] * wheelbase : 0;
      sample.wheel_speed[i] = std::copysign(std::hypot(along, across), along);
    }
    sample.yaw_rate = now[2];
    sample.steering_angle = std::nan("");
    return sample;
  }

 private:
  static constexpr double kStep = 0.5e-3;

  geometry::Vector6 motion(double t) const {
    return unseen_ ? geometry::Vector6(twist_(t) + unseen_(t)) : twist_(t);
  }

  TwistFunction twist_, unseen_;
  std::vector<Eigen::Isometry3d> poses_;
};

inline Stamp seconds(double t) {
  return Stamp::from_ns(static_cast<int64_t>(std::llround(t * 1e9)));
}

}  // namespace infuse::motion
