#include "tests/bench/lying_drive.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::streetmap::bench {
namespace {

constexpr double kRamp = 3;           // s, in which the pace changes from one to another
constexpr double kStands = 4;         // s, before and after it is carried
constexpr double kCarriedPace = 0.6;  // of the route's speed
constexpr double kHalfSpan = 0.02;    // s, of the differences that give the twist

}  // namespace

LyingDrive::LyingDrive(const geometry::Trajectory& route, double first, const WheelFault& fault,
                       double begin, double seconds)
    : route_(route),
      fault_(fault),
      begin_(begin),
      route_seconds_(route_times(first, seconds)),
      twists_(twists()),
      drive_(seconds, [this](double t) { return twist(t); }) {}

std::vector<double> LyingDrive::route_times(double first, double seconds) const {
  std::vector<double> times;
  double s = first;
  for (double t = 0; t <= seconds + 1; t += kStep) {
    times.push_back(s);
    s += kStep * pace(t + kStep / 2);
  }
  return times;
}

std::vector<geometry::Vector6> LyingDrive::twists() const {
  const auto T = [&](double when) {
    return route_.at(route_[0].stamp + from_seconds(std::max(when, 0.0))).T_odom_vehicle;
  };
  std::vector<geometry::Vector6> all;
  for (size_t i = 0; i < route_seconds_.size(); ++i) {
    const double at = route_seconds_[i];
    all.push_back(pace(kStep * static_cast<double>(i)) / (2 * kHalfSpan) *
                  geometry::log(T(at - kHalfSpan).inverse() * T(at + kHalfSpan)));
  }
  return all;
}

// One, but for a vehicle that is carried: it brakes, stands, is carried, stands and drives on.
double LyingDrive::pace(double t) const {
  if (!fault_.carried) return 1;
  const auto ramp = [](double since) { return std::clamp(since / kRamp, 0.0, 1.0); };
  const double end = begin_ + fault_.seconds;
  const double before = 1 - ramp(t - (begin_ - kStands - kRamp));
  const double carried = kCarriedPace * std::min(ramp(t - begin_), ramp(end - t));
  return std::max({before, carried, ramp(t - (end + kStands))});
}

double LyingDrive::route_seconds(double t) const {
  const auto i = std::min(static_cast<size_t>(std::max(t, 0.0) / kStep), route_seconds_.size() - 2);
  const double share = t / kStep - static_cast<double>(i);
  return route_seconds_[i] + share * (route_seconds_[i + 1] - route_seconds_[i]);
}

geometry::Vector6 LyingDrive::twist(double t) const {
  const auto i = std::min(static_cast<size_t>(std::max(t, 0.0) / kStep), twists_.size() - 2);
  const double share = t / kStep - static_cast<double>(i);
  return twists_[i] + share * (twists_[i + 1] - twists_[i]);
}

double LyingDrive::factor(size_t wheel, double t) const {
  if (t < begin_ || t >= fault_end()) return 1;
  return fault_.carried ? 0 : fault_.factor[wheel];
}

Eigen::Isometry3d LyingDrive::pose(double t) const {
  return route_.at(route_[0].stamp + from_seconds(route_seconds(t))).T_odom_vehicle;
}

}  // namespace infuse::streetmap::bench
