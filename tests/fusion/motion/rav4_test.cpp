#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iostream>
#include <numbers>
#include <sstream>

#include "drivers/measurement/angles.hpp"
#include "drivers/vehicle/candump.hpp"
#include "drivers/vehicle/signal_map.hpp"
#include "fusion/motion/odometry_filter.hpp"
#include "tests/real_data.hpp"

namespace infuse::motion {
namespace {

using Row = std::vector<double>;

/// Reads the rows of a numeric table without its header; converts the first column from seconds to
/// ns.
std::vector<std::pair<Stamp, Row>> read_table(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  std::vector<std::pair<Stamp, Row>> rows;
  while (std::getline(stream, line)) {
    const size_t point = line.find('.'), comma = line.find(',');
    const std::string digits =
        (line.substr(point + 1, comma - point - 1) + "000000000").substr(0, 9);
    const int64_t ns = std::stoll(line.substr(0, point)) * 1'000'000'000 + std::stoll(digits);
    Row row;
    std::istringstream fields(line.substr(comma + 1));
    for (std::string field; std::getline(fields, field, ',');) {
      row.push_back(field.empty() ? std::nan("") : std::stod(field));
    }
    rows.emplace_back(Stamp::from_ns(ns), row);
  }
  return rows;
}

struct TruePosition {
  Stamp stamp;
  Eigen::Vector3d east_north_up;
};

/// Reads the reference positions and transforms them from earth-centred coordinates to a tangent
/// plane at the first.
std::vector<TruePosition> read_truth(const std::filesystem::path& file) {
  const auto rows = read_table(file);
  const Eigen::Vector3d origin(rows[0].second[0], rows[0].second[1], rows[0].second[2]);
  const double longitude = std::atan2(origin.y(), origin.x());
  const double latitude =
      std::atan2(origin.z(), std::hypot(origin.x(), origin.y()) * (1 - 0.00669437999));
  Eigen::Matrix3d R;
  R << -std::sin(longitude), std::cos(longitude), 0, -std::sin(latitude) * std::cos(longitude),
      -std::sin(latitude) * std::sin(longitude), std::cos(latitude),
      std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
      std::sin(latitude);
  std::vector<TruePosition> positions;
  for (const auto& [stamp, row] : rows) {
    positions.push_back({stamp, R * (Eigen::Vector3d(row[0], row[1], row[2]) - origin)});
  }
  return positions;
}

/// Direction of travel between the positions half a second before and after, counter-clockwise from
/// east.
double course_at(const std::vector<TruePosition>& truth, size_t i) {
  const Eigen::Vector3d displacement = truth[i + 10].east_north_up - truth[i - 10].east_north_up;
  return std::atan2(displacement.y(), displacement.x());
}

vehicle::SignalMap rav4() {
  vehicle::SignalMap map;
  map.interface = "can0";
  map.wheel_speed = {vehicle::SignalSource{"WHEEL_SPEEDS.WHEEL_SPEED_FL"},
                     vehicle::SignalSource{"WHEEL_SPEEDS.WHEEL_SPEED_FR"},
                     vehicle::SignalSource{"WHEEL_SPEEDS.WHEEL_SPEED_RL"},
                     vehicle::SignalSource{"WHEEL_SPEEDS.WHEEL_SPEED_RR"}};
  map.yaw_rate = {"KINEMATICS.YAW_RATE"};
  map.steering_angle = {"STEER_ANGLE_SENSOR.STEER_ANGLE"};
  map.steering_fraction = {"STEER_ANGLE_SENSOR.STEER_FRACTION"};
  return map;
}

OdometryOptions rav4_options() {
  OdometryOptions options;
  options.wheelbase = 2.65;
  options.track = 1.57;
  options.steering_ratio = 16.9;
  options.gnss_delay = Duration(120'000'000);  // of this receiver's speed
  options.gnss_course_noise = 0.005;           // of the reference, used instead of a receiver
  options.reorder = Duration(150'000'000);
  return options;
}

struct Inputs {
  bool can_yaw_rate = true;
  bool gyro = false;
  bool gnss_speed = false;       // during the first 10 s
  bool reference_course = true;  // during the first 10 s
  bool steering_ratio = true;    // it is known
};

struct Drift {
  double distance = 0;      // m driven
  double position = 0;      // m, at the end
  double max_position = 0;  // m, at any time
  double heading = 0;       // rad, at the end, mean of the last two seconds
  OdometryReport report;
  double yaw_bias =
      0;  // rad/s: mean yaw rate on the bus minus the mean turn rate of the true course
  double wheel_scale = 0;  // true distance over the distance of the wheels
};

/// Dead reckoning over the minute. During the first 10 s the filter receives the course (of the
/// reference positions) and, if requested, the speed of the GNSS receiver; then only wheels and yaw
/// rate.
Drift dead_reckon(const std::filesystem::path& folder, const Inputs& inputs) {
  const auto truth = read_truth(folder / "pose_ecef.csv");
  const auto dbc = vehicle::read_dbc(folder / "vehicle.dbc");
  auto decoder = vehicle::VehicleDecoder::create(dbc->dbc, rav4()).value();
  OdometryOptions options = rav4_options();
  if (!inputs.steering_ratio) options.steering_ratio = 0;
  OdometryFilter filter(options, {.capacity = 10000});
  const Stamp begin = truth[10].stamp, learn_until = truth[0].stamp + Duration(10'000'000'000);

  // Initial pose: true position, course known to a few degrees.
  Eigen::Isometry3d T_odom_vehicle = Eigen::Isometry3d::Identity();
  T_odom_vehicle.linear() = geometry::rotation_exp({0, 0, course_at(truth, 10)});
  geometry::Matrix6 unsure = geometry::Matrix6::Zero();
  unsure(2, 2) = std::pow(3 * kDegree, 2);
  filter.set_pose(T_odom_vehicle, unsure);

  const auto gyro = read_table(folder / "imu_gyro_frd.csv");
  const auto gnss = read_table(folder / "gnss_ublox.csv");
  size_t next_gyro = 0, next_gnss = 0, next_course = 10;
  std::ifstream log(folder / "raw_can_candump.log");
  vehicle::CandumpReader reader("raw_can_candump.log");
  double turned = 0, rolled = 0;  // from the bus
  std::optional<Stamp> last_yaw, last_wheels;
  const Stamp end = truth[truth.size() - 12].stamp;
  for (std::string line; std::getline(log, line);) {
    const auto frame = reader.read(line);
    if (!frame || frame->stamp < begin) continue;
    for (; next_gyro < gyro.size() && gyro[next_gyro].first <= frame->stamp; ++next_gyro) {
      const auto& [stamp, row] = gyro[next_gyro];
      if (!inputs.gyro || stamp < begin) continue;
      const double nan = std::nan("");
      filter.add(ImuSample{stamp, {row[0], -row[1], -row[2]}, {nan, nan, nan}});
    }
    for (; next_gnss < gnss.size() && gnss[next_gnss].first <= frame->stamp; ++next_gnss) {
      const auto& [stamp, row] = gnss[next_gnss];
      if (!inputs.gnss_speed || stamp < begin || stamp > learn_until) continue;
      GnssFix fix;
      fix.stamp = stamp;
      fix.speed = row[2];
      fix.course = std::nan("");
      fix.valid = true;
      filter.add(fix);
    }
    for (; next_course + 10 < truth.size() && truth[next_course].stamp <= frame->stamp;
         next_course += 10) {
      if (!inputs.reference_course || truth[next_course].stamp > learn_until) continue;
      GnssFix fix;
      fix.stamp = truth[next_course].stamp + rav4_options().gnss_delay;
      fix.speed = std::nan("");
      fix.course = std::numbers::pi / 2 - course_at(truth, next_course);
      fix.valid = true;
      filter.add(fix);
    }
    auto samples = decoder.decode(*frame);
    if (!samples.wheels) continue;
    if (frame->stamp < end && std::isfinite(samples.wheels->yaw_rate)) {
      if (last_yaw) turned += samples.wheels->yaw_rate * to_seconds(frame->stamp - *last_yaw);
      last_yaw = frame->stamp;
    }
    if (frame->stamp < end && std::isfinite(samples.wheels->wheel_speed[0])) {
      double mean = 0;
      for (const double speed : samples.wheels->wheel_speed) mean += speed / 4;
      if (last_wheels) rolled += mean * to_seconds(frame->stamp - *last_wheels);
      last_wheels = frame->stamp;
    }
    if (!inputs.can_yaw_rate) samples.wheels->yaw_rate = std::nan("");
    filter.add(*samples.wheels);
  }
  filter.flush();
  EXPECT_TRUE(filter.usable()) << filter.reason();

  Drift drift;
  drift.report = filter.report();
  const geometry::Trajectory& trajectory = filter.trajectory();
  size_t headings = 0;
  std::optional<Eigen::Vector3d> origin;
  for (size_t i = 11; i + 11 < truth.size(); ++i) {
    const auto pose = trajectory.at(truth[i].stamp);
    if (!pose.usable()) {
      EXPECT_LT(i, 13u) << pose.reason;
      continue;
    }
    const Eigen::Vector3d true_position = truth[i].east_north_up;
    if (!origin) origin = true_position - pose.T_odom_vehicle.translation();
    drift.distance += (true_position - truth[i - 1].east_north_up).norm();
    drift.position = (pose.T_odom_vehicle.translation() + *origin - true_position).head<2>().norm();
    drift.max_position = std::max(drift.max_position, drift.position);
    if (i + 51 > truth.size()) {
      const Eigen::Vector3d ahead = pose.T_odom_vehicle.linear().col(0);
      drift.heading += wrap_angle(std::atan2(ahead.y(), ahead.x()) - course_at(truth, i));
      ++headings;
    }
  }
  drift.heading /= static_cast<double>(headings);
  drift.yaw_bias =
      (turned - wrap_angle(course_at(truth, truth.size() - 12) - course_at(truth, 10))) /
      to_seconds(end - begin);
  drift.wheel_scale = drift.distance / rolled;
  return drift;
}

void record(const char* name, const Drift& drift) {
  std::ostringstream text;
  text << name << ": " << drift.distance << " m, drift " << drift.position << " m ("
       << 100 * drift.position / drift.distance << " %), heading " << drift.heading / kDegree
       << "°; yaw-rate bias " << drift.report.yaw_rate_bias.value / kDegree << " ± "
       << drift.report.yaw_rate_bias.sigma / kDegree << " (is " << drift.yaw_bias / kDegree
       << ") °/s; wheel scale " << drift.report.wheel_scale.value << " ± "
       << drift.report.wheel_scale.sigma << " (true " << drift.wheel_scale << ")";
  testing::Test::RecordProperty("drift", text.str());
  std::cout << text.str() << "\n";
}

// With the gyro of the inertial unit besides the bus, and the speed of the receiver during the
// first 10 s. Target: 1 % and 1.5°.
TEST(Odometry, RealRav4WithGyroDriftsAtMostOnePercentAndOneAndAHalfDegrees) {
  INFUSE_REAL_DATA_OR_SKIP(path, "can/rav4");
  const Drift drift = dead_reckon(path, {.gyro = true, .gnss_speed = true});
  record("bus and gyro, 10 s of course and speed", drift);
  EXPECT_GT(drift.distance, 990);
  EXPECT_LT(drift.max_position, 0.01 * drift.distance);
  EXPECT_LT(std::abs(drift.heading), 1.5 * kDegree);
  EXPECT_LT(std::abs(drift.report.yaw_rate_bias.value - drift.yaw_bias),
            3 * drift.report.yaw_rate_bias.sigma);
  EXPECT_LT(drift.report.yaw_rate_bias.sigma, 0.05 * kDegree);
  EXPECT_LT(std::abs(drift.report.wheel_scale.value - drift.wheel_scale),
            3 * drift.report.wheel_scale.sigma);
  EXPECT_EQ(drift.report.outliers, 0u);
}

// From the bus alone: its yaw rate has steps of 0.244°/s and a bias of 0.41°/s. The car never
// stands, so the bias follows from steering and 10 s of course. Uncorrected, the error would be
// 24°.
TEST(Odometry, RealRav4FromTheBusAlone) {
  INFUSE_REAL_DATA_OR_SKIP(path, "can/rav4");
  for (const bool course : {true, false}) {
    const Drift drift = dead_reckon(path, {.reference_course = course});
    record(course ? "bus, 10 s of course" : "bus", drift);
    EXPECT_LT(drift.max_position, 0.02 * drift.distance);
    EXPECT_LT(std::abs(drift.heading), 2 * kDegree);
    EXPECT_LT(std::abs(drift.report.yaw_rate_bias.value - drift.yaw_bias),
              3 * drift.report.yaw_rate_bias.sigma);
    EXPECT_NEAR(drift.report.wheel_scale.value, 1, 1e-9);
    EXPECT_LT(std::abs(drift.wheel_scale - 1), 2 * drift.report.wheel_scale.sigma);
  }
}

// Nobody states the ratio: it is learned in bends, and the angle bounds the bias on straight roads.
TEST(Odometry, RealRav4FromTheBusAloneLearnsItsSteeringRatio) {
  INFUSE_REAL_DATA_OR_SKIP(path, "can/rav4");
  const Drift drift = dead_reckon(path, {.reference_course = false, .steering_ratio = false});
  record("bus, steering ratio unknown", drift);
  EXPECT_LT(drift.max_position, 0.03 * drift.distance);
  EXPECT_LT(std::abs(drift.heading), 2 * kDegree);
  EXPECT_LT(std::abs(drift.report.yaw_rate_bias.value - drift.yaw_bias),
            3 * drift.report.yaw_rate_bias.sigma);
}

}  // namespace
}  // namespace infuse::motion
