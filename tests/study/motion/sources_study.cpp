#include "tests/study/motion/sources_study.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <istream>
#include <limits>
#include <map>
#include <ostream>
#include <random>
#include <sstream>

#include "drivers/measurement/angles.hpp"
#include "tests/fusion/motion/simulated_sensors.hpp"

namespace infuse::study {
namespace {

using namespace motion;

constexpr double kSeconds = 60, kSweep = 0.1;  // s
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kHeader = "seed,fault,all,wheels and bus,wheels and gyro,gnss,lidar";

enum Fault : int { kNothing, kSlip, kLock, kFastGnss, kTurnedGnss, kTunnel, kWrongLidar, kFaults };
constexpr std::array<const char*, kFaults> kFaultNames = {
    "none", "slip", "lock", "fast gnss", "turned gnss", "tunnel", "wrong lidar"};

/// What is drawn of a drive.
struct Drawn {
  uint64_t seed;
  bool wheels, bus, gyro, gnss, lidar;
  double turns, slopes, speed, stops;             // rad/s, rad/s, m/s, m/s
  double scale, bus_bias, gyro_bias, gyro_delay;  // 1, rad/s, rad/s, s
  double gnss_interval, gnss_delay, lidar_noise;  // s, s, 1
  Fault fault = kNothing;
  double since, until, size;  // s, s, of the fault: its own unit

  explicit Drawn(uint64_t seed_of_drive) : seed(seed_of_drive) {
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

  /// True if the drive has the source that goes wrong.
  bool concerns(Fault which) const {
    if (which == kSlip || which == kLock) return wheels;
    if (which == kFastGnss || which == kTurnedGnss) return gnss;
    return which == kNothing || lidar;
  }
  bool is_wrong(Fault which, double t) const { return fault == which && t > since && t < until; }
};

TrueDrive roads(const Drawn& drawn) {
  return TrueDrive(kSeconds + 1, [drawn](double t) {
    const double phase = 0.1 * static_cast<double>(drawn.seed % 63);
    geometry::Vector6 twist = geometry::Vector6::Zero();
    twist[0] = drawn.slopes * std::sin(1.1 * t + phase);
    twist[1] = drawn.slopes * std::cos(0.8 * t + phase);
    twist[2] = drawn.turns * std::pow(std::sin(0.3 * t + phase), 3);
    twist[3] = drawn.speed + drawn.stops * std::sin(0.25 * t + 2 * phase);
    return twist;
  });
}

struct Used {
  bool wheels, bus, gyro, gnss, lidar;
};

Used sources_of(SourceSet set, const Drawn& d) {
  switch (set) {
    case SourceSet::kWheelsAndBus:
      return {d.wheels && d.bus, d.bus, false, false, false};
    case SourceSet::kWheelsAndGyro:
      return {d.wheels && d.gyro, false, d.wheels && d.gyro, false, false};
    case SourceSet::kGnss:
      return {false, false, false, d.gnss, false};
    case SourceSet::kLidar:
      return {false, false, false, false, d.lidar};
    default:
      return {d.wheels, d.bus, d.gyro, d.gnss, d.lidar};
  }
}

/// The sensors of a drive, with their errors; a set of sources sees the same samples.
class Sensors {
 public:
  Sensors(const Drawn& drawn, const TrueDrive& drive)
      : drawn_(drawn),
        drive_(drive),
        wheels_(drive, 10 * drawn.seed),
        gyro_(drive, 10 * drawn.seed + 1),
        gnss_(drive, 10 * drawn.seed + 2),
        lidar_(drive, 10 * drawn.seed + 3,
               {3e-4 * drawn.lidar_noise, 0.005 * drawn.lidar_noise, OdometryOptions()}) {}

  WheelOdometry wheels(double t, bool bus) {
    WheelOdometry sample = wheels_.wheels(t, drawn_.scale, drawn_.bus_bias);
    if (!bus) sample.yaw_rate = kNone;
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
  const Drawn& drawn_;
  const TrueDrive& drive_;
  SimulatedSensors wheels_, gyro_, gnss_, lidar_;
};

/// rms over stretches of 10 s; NaN if there is no pose.
double error_of(const geometry::Trajectory& trajectory, const TrueDrive& drive) {
  constexpr double kStretch = 10, kFrom = 15;  // s; until then what is constant is learned
  double square = 0;
  int count = 0;
  for (double t = kFrom; t + kStretch < kSeconds - 1; t += 1, ++count) {
    const auto from = trajectory.at(seconds(t)), to = trajectory.at(seconds(t + kStretch));
    if (!from.usable() || !to.usable()) return kNone;
    const Eigen::Isometry3d moved = from.T_odom_vehicle.inverse() * to.T_odom_vehicle;
    const Eigen::Isometry3d truth = drive.pose(t).inverse() * drive.pose(t + kStretch);
    square += (moved.translation() - truth.translation()).head<2>().squaredNorm();
  }
  return std::sqrt(square / count);
}

/// The settings are those of the daemon for such sensors.
double drive_with(const Used& used, const Drawn& drawn, const TrueDrive& drive) {
  if (!used.wheels && !used.gnss && !used.lidar) return kNone;
  OdometryOptions options;
  options.planar = !used.gyro && !used.lidar;
  options.east_heading_sigma = 10;
  OdometryFilter filter(options, {.capacity = 10'000});
  Sensors sensors(drawn, drive);
  double next_fix = 0.05;
  for (int step = 1; step * 0.02 < kSeconds; ++step) {
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
    const RelativePose pose = sensors.motion(std::max(0.0, t - kSweep), t);
    add_sweep(filter, t, step > 5 ? &pose : nullptr);
  }
  filter.flush();
  return error_of(filter.trajectory(), drive);
}

void write_line(std::ostream& out, const std::string& name, std::vector<double> ratios) {
  std::sort(ratios.begin(), ratios.end());
  char line[96];
  std::snprintf(line, sizeof line, "| %s | %zu | %.2f | %.2f |\n", name.c_str(), ratios.size(),
                ratios[ratios.size() / 2], ratios.back());
  out << line;
}

}  // namespace

double SourcesTrial::ratio() const {
  double best = kNone;
  for (size_t set = 1; set < kSourceSets; ++set) best = std::fmin(best, error[set]);  // no NaN
  return error[0] / best;
}

SourcesTrial drive_by_sources(uint64_t seed) {
  const Drawn drawn(seed);
  const TrueDrive drive = roads(drawn);
  SourcesTrial trial;
  trial.seed = seed;
  trial.fault = kFaultNames[drawn.fault];
  for (size_t set = 0; set < kSourceSets; ++set)
    trial.error[set] = drive_with(sources_of(static_cast<SourceSet>(set), drawn), drawn, drive);
  return trial;
}

void write_sources_header(std::ostream& out) { out << kHeader << '\n'; }

void write_sources_row(std::ostream& out, const SourcesTrial& trial) {
  out << trial.seed << ',' << trial.fault;
  for (const double error : trial.error) out << ',' << error;
  out << '\n';
}

std::vector<SourcesTrial> read_sources_rows(std::istream& in) {
  std::vector<SourcesTrial> trials;
  for (std::string line; std::getline(in, line);) {
    SourcesTrial trial;
    std::istringstream fields(line);
    std::string field;
    size_t count = 0;
    for (; count < kSourceSets + 2 && std::getline(fields, field, ','); ++count) {
      char* end = nullptr;
      if (count == 0) trial.seed = std::strtoull(field.c_str(), &end, 10);
      if (count == 1) trial.fault = field;
      if (count >= 2) trial.error[count - 2] = std::strtod(field.c_str(), &end);
      if (count != 1 && *end != 0) break;
    }
    if (count == kSourceSets + 2 && !in.eof()) trials.push_back(trial);
  }
  return trials;
}

void write_sources_summary(std::ostream& out, const std::vector<SourcesTrial>& trials) {
  std::vector<double> all;
  std::map<std::string, std::vector<double>> by_fault;
  for (const SourcesTrial& trial : trials) {
    if (!std::isfinite(trial.ratio())) continue;
    all.push_back(trial.ratio());
    by_fault[trial.fault].push_back(trial.ratio());
  }
  out << "| fault | drives | error over that of the best sources alone, median | worst |\n"
      << "|---|---|---|---|\n";
  for (const auto& [fault, ratios] : by_fault) write_line(out, fault, ratios);
  if (!all.empty()) write_line(out, "all", all);
  out << trials.size() - all.size() << " drives without a pose somewhere\n";
}

}  // namespace infuse::study
