#include "tests/study/months/simulated_vehicle.hpp"

#include <cmath>
#include <numbers>

namespace infuse::study {
namespace {

constexpr int kWheelsPerSecond = 20;
constexpr int kWheelsPerFix = 4;
constexpr double kEquatorRadius = 6378'137, kMeridianRadius = 6'335'439;  // m

}  // namespace

void SimulatedVehicle::drive(Stamp now, bool bus, bool gnss, const FaultSchedule& faults) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  const Fault* slip = faults.find("vehicle", "slip");
  const Fault* fast = faults.find("gnss", "fast");
  const Fault* turned = faults.find("gnss", "turned");
  for (int i = 0; i < kWheelsPerSecond; ++i) {
    const double dt = 1.0 / kWheelsPerSecond;
    seconds_ += dt;
    const double speed = 10 + 3 * std::sin(seconds_ / 40);
    const double yaw_rate = 0.1 * std::sin(seconds_ / 25);
    heading_ += yaw_rate * dt;
    east_ += speed * std::cos(heading_) * dt;
    north_ += speed * std::sin(heading_) * dt;
    const Stamp stamp = now - from_seconds(1) + from_seconds((i + 1) * dt - 0.03);
    if (bus) {
      const double measured = speed * (slip != nullptr ? 1 + slip->value : 1);
      const double across = yaw_rate * 1.55 / 2;
      odometry_->add(
          WheelOdometry{.stamp = stamp,
                        .wheel_speed = {kUnknown, kUnknown, measured - across + noise(0.03),
                                        measured + across + noise(0.03)},
                        .yaw_rate = yaw_rate + noise(0.003),
                        .steering_angle = kUnknown});
    }
    if (gnss && i % kWheelsPerFix == 0) {
      GnssFix fix{.stamp = stamp, .altitude = kUnknown, .hdop = 1, .valid = true};
      fix.latitude = (north_ + noise(0.3)) / kMeridianRadius;  // near 0, 0
      fix.longitude = (east_ + noise(0.3)) / kEquatorRadius;
      fix.speed = speed + noise(0.1) + (fast != nullptr ? fast->value : 0);
      fix.course = std::fmod(std::numbers::pi / 2 - heading_ + noise(0.01) +
                                 (turned != nullptr ? turned->value : 0) + 200 * std::numbers::pi,
                             2 * std::numbers::pi);
      odometry_->add(fix);
    }
  }
  odometry_->process_until(now - from_seconds(0.03));
}

}  // namespace infuse::study
