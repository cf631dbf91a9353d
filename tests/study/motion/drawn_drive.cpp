#include "tests/study/motion/drawn_drive.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "drivers/measurement/angles.hpp"

namespace infuse::study {

using namespace motion;

namespace {

constexpr double kTurn = 0.1;  // s, of the lidar

/// The sensors of a drive, with their errors; a set of sources sees the same samples.
class Sensors {
 public:
  Sensors(const DrawnDrive& drawn, const TrueDrive& drive)
      : drawn_(drawn),
        drive_(drive),
        wheels_(drive, 10 * drawn.seed),
        gyro_(drive, 10 * drawn.seed + 1),
        gnss_(drive, 10 * drawn.seed + 2),
        lidar_(drive, 10 * drawn.seed + 3,
               {3e-4 * drawn.lidar_noise, 0.005 * drawn.lidar_noise, OdometryOptions()}) {}

  WheelOdometry wheels(double t, bool bus) {
    WheelOdometry sample = wheels_.wheels(t, drawn_.scale, drawn_.bus_bias);
    if (!bus) sample.yaw_rate = std::nan("");
    for (double& speed : sample.wheel_speed) {
      if (drawn_.is_wrong(kSlip, t)) speed *= 1 + drawn_.size;
      if (drawn_.is_wrong(kLock, t)) speed = 0;
    }
    return sample;
  }
  ImuSample gyro(double t) {
    ImuSample sample = gyro_.gyro(std::max(0.0, t - drawn_.gyro_delay),
                                  Eigen::Vector3d::Constant(drawn_.gyro_bias));
    sample.stamp = seconds(t);
    return sample;
  }
  GnssFix fix(double t) {
    GnssFix fix = gnss_.gnss(std::max(0.0, t - drawn_.gnss_delay));
    fix.stamp = seconds(t);
    if (drawn_.is_wrong(kFastGnss, t)) fix.speed *= 1 + drawn_.size;
    if (drawn_.is_wrong(kTurnedGnss, t)) fix.course += drawn_.size;
    return fix;
  }
  RelativePose motion(double from, double to) {
    RelativePose pose = lidar_.lidar(from, to, drawn_.is_wrong(kTunnel, to));
    if (drawn_.is_wrong(kWrongLidar, to)) pose.T_from_to.translation().x() *= 1 + drawn_.size;
    return pose;
  }

 private:
  const DrawnDrive& drawn_;
  const TrueDrive& drive_;
  SimulatedSensors wheels_, gyro_, gnss_, lidar_;
};

}  // namespace

DrawnDrive::DrawnDrive(uint64_t seed_of_drive) : seed(seed_of_drive) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  do {
    wheels = uniform(0, 1) < 0.8;
    bus = wheels && uniform(0, 1) < 0.6;
    gyro = uniform(0, 1) < 0.7;
    gnss = uniform(0, 1) < 0.7;
    lidar = uniform(0, 1) < 0.7;
  } while (!(wheels && (bus || gyro)) + !gnss + !lidar > 1);  // two sets at least
  turns = uniform(0.05, 0.5);
  slopes = uniform(0, 0.03);
  speed = uniform(5, 20);
  stops = uniform(0, 0.6) * speed;
  scale = 1 + 0.01 * normal(random);
  bus_bias = 0.3 * kDegree * normal(random);
  gyro_bias = 0.3 * kDegree * normal(random);
  gyro_delay = uniform(0, 0.08);
  const double rates[] = {1.0, 0.2, 0.1};
  gnss_interval = rates[std::min(2, static_cast<int>(uniform(0, 3)))];
  gnss_delay = uniform(0, 0.3);
  lidar_noise = std::exp(uniform(-0.7, 1.1));  // also fog and few planes
  do {
    fault = static_cast<Fault>(std::uniform_int_distribution<int>(0, kFaults - 1)(random));
  } while (!concerns(fault));
  since = uniform(25, 45);
  until = since + (fault == kWrongLidar ? 0.3 : uniform(0.5, 10));
  size = uniform(0.1, 0.5);
}

bool DrawnDrive::concerns(Fault which) const {
  if (which == kSlip || which == kLock) return wheels;
  if (which == kFastGnss || which == kTurnedGnss) return gnss;
  return which == kNothing || lidar;
}

TrueDrive true_drive(const DrawnDrive& drawn, double seconds, TrueDrive::TwistFunction unseen) {
  const auto twist = [drawn](double t) {
    const double phase = 0.1 * static_cast<double>(drawn.seed % 63);
    geometry::Vector6 now = geometry::Vector6::Zero();
    now[0] = drawn.slopes * std::sin(1.1 * t + phase);
    now[1] = drawn.slopes * std::cos(0.8 * t + phase);
    now[2] = drawn.turns * std::pow(std::sin(0.3 * t + phase), 3);
    now[3] = drawn.speed + drawn.stops * std::sin(0.25 * t + 2 * phase);
    return now;
  };
  return TrueDrive(seconds + 1, twist, std::move(unseen));
}

geometry::Trajectory drive_by(const Used& used, const DrawnDrive& drawn, const TrueDrive& drive) {
  OdometryOptions options;
  options.planar = !used.gyro && !used.lidar;
  options.east_heading_sigma = 10;
  OdometryFilter filter(options, {.capacity = 10'000});
  Sensors sensors(drawn, drive);
  double next_fix = 0.05;
  for (int step = 1; step * 0.02 < drive.seconds() - 1; ++step) {
    const double t = 0.02 * step;
    if (used.wheels) filter.add(sensors.wheels(t, used.bus));
    if (used.gyro) {
      filter.add(sensors.gyro(t - 0.01));
      filter.add(sensors.gyro(t));
    }
    if (used.gnss && t >= next_fix) {
      filter.add(sensors.fix(t));
      next_fix += drawn.gnss_interval;
    }
    if (!used.lidar || step % 5 != 0) continue;
    const RelativePose pose = sensors.motion(std::max(0.0, t - kTurn), t);
    add_sweep(filter, t, step > 5 ? &pose : nullptr);
  }
  filter.flush();
  return filter.trajectory();
}

}  // namespace infuse::study
