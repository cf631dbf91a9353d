#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <numbers>
#include <span>
#include <sstream>
#include <variant>
#include <vector>

#include "drivers/gnss/local_frame.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/text/text_file.hpp"
#include "drivers/vehicle/candump.hpp"
#include "drivers/vehicle/signal_map.hpp"
#include "fusion/motion/odometry_filter.hpp"
#include "tests/read_xz.hpp"
#include "tests/real_data.hpp"

namespace infuse::motion {
namespace {

/// The answer to a request for the vehicle's speed, as OBD-II (SAE J1979) has it.
constexpr const char* kObd = R"(
BO_ 2024 OBD: 8 X
 SG_ PID M : 16|8@1+ (1,0) [0|255] "" X
 SG_ SPEED m13 : 24|8@1+ (1,0) [0|255] "km/h" X
)";

/// The speed has steps of 1 km/h, twice a second. The unit is mounted with its x axis up.
vehicle::SignalMap signals() {
  vehicle::SignalMap map;
  map.speed = {"OBD.SPEED"};
  map.angular_velocity[2] = {"gnss_imu.AngularRateX"};
  return map;
}

using Sample = std::variant<WheelOdometry, ImuSample, GnssFix>;

Stamp stamp_of(const Sample& sample) {
  return std::visit([](const auto& s) { return s.stamp; }, sample);
}

/// Counter-clockwise from east.
double heading_of(const GnssFix& fix) { return std::numbers::pi / 2 - fix.course; }

void add(OdometryFilter& filter, const Sample& sample) {
  std::visit([&](const auto& s) { filter.add(s); }, sample);
}

class FixReader {
 public:
  explicit FixReader(const vehicle::Dbc& dbc)
      : position_(dbc.find("gnss_pos")),
        attitude_(dbc.find("gnss_attitude")),
        speed_(dbc.find("gnss_speed")) {}

  /// The fix that a frame completes: position, attitude and speed follow each other within 2 ms.
  std::optional<GnssFix> read(const vehicle::CanFrame& frame) {
    const auto value = [&](const vehicle::DbcMessage* message, const char* signal) {
      return vehicle::decode(*message, *message->find_signal(signal), frame.payload()).value();
    };
    if (frame.interface_name() != "can2") return std::nullopt;
    if (frame.id == position_->id) {
      fix_.stamp = frame.stamp;
      fix_.latitude = value(position_, "Latitude") * kDegree;
      fix_.longitude = value(position_, "Longitude") * kDegree;
    }
    if (frame.id == attitude_->id) fix_.course = value(attitude_, "Heading") * kDegree;
    if (frame.id != speed_->id) return std::nullopt;
    fix_.speed = value(speed_, "Speed");
    fix_.valid = true;
    return fix_;
  }

 private:
  const vehicle::DbcMessage *position_, *attitude_, *speed_;
  GnssFix fix_;
};

/// Both files, 20 minutes.
std::vector<Sample> read_recording(const std::filesystem::path& folder) {
  const auto text = text::read_text(folder / "canmod-gps.dbc", 1'000'000);
  const auto dbc = vehicle::parse_dbc(text.value() + kObd, "canmod-gps.dbc").dbc;
  auto decoder = vehicle::VehicleDecoder::create(dbc, signals()).value();
  FixReader fixes(dbc);
  std::vector<Sample> all;
  for (const char* part : {"part2.log.xz", "part3.log.xz"}) {
    std::istringstream lines(read_xz(folder / part));
    for (std::string line; std::getline(lines, line);) {
      const auto frame = vehicle::parse_candump_line(line);
      if (!frame) continue;
      if (const auto fix = fixes.read(*frame)) all.emplace_back(*fix);
      const auto samples = decoder.decode(*frame);
      if (samples.wheels) all.emplace_back(*samples.wheels);
      if (samples.imu) all.emplace_back(*samples.imu);
    }
  }
  return all;
}

/// Dead reckoning for a minute without GNSS.
struct Outage {
  double distance = 0, position = 0;  // m
  double heading = 0;                 // rad
};

/// Compares dead reckoning by `samples` with what the receiver states, from its first fix to its
/// last. `filter` goes on without GNSS.
Outage dead_reckon(OdometryFilter filter, std::span<const Sample> samples) {
  const Duration delay = from_seconds(filter.report().gnss_delay.value);
  std::vector<GnssFix> fixes;
  for (const Sample& sample : samples) {
    if (const auto* fix = std::get_if<GnssFix>(&sample)) {
      fixes.push_back(*fix);
    } else {
      add(filter, sample);
    }
  }
  filter.flush();
  const GnssFix &first = fixes.front(), &last = fixes.back();
  const gnss::LocalFrame map = gnss::make_local_frame(first.latitude, first.longitude);
  Outage outage;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  for (const GnssFix& fix : fixes) {
    const Eigen::Vector3d next = gnss::to_local(map, fix.latitude, fix.longitude, 0);
    outage.distance += (next - place).head<2>().norm();
    place = next;
  }
  const auto from = filter.trajectory().at(first.stamp - delay);
  const auto to = filter.trajectory().at(last.stamp - delay);
  EXPECT_TRUE(from.usable() && to.usable()) << from.reason << to.reason;
  outage.position = (to.T_odom_vehicle.translation() - from.T_odom_vehicle.translation() - place)
                        .head<2>()
                        .norm();
  const Eigen::Vector3d ahead = to.T_odom_vehicle.linear().col(0);
  outage.heading = wrap_angle(std::atan2(ahead.y(), ahead.x()) - heading_of(last));
  return outage;
}

// Twenty minutes. Every other minute is driven once more without GNSS. By least squares over the
// whole drive, the scale of the speed is 0.992, and the receiver states it 0.4 s later.
TEST(Odometry, RealAarhusByTheSpeedOfTheBus) {
  INFUSE_REAL_DATA_OR_SKIP(path, "can/aarhus");
  const std::vector<Sample> samples = read_recording(path);
  OdometryFilter filter(OdometryOptions(), {.capacity = 13'000});
  Eigen::Isometry3d T_odom_vehicle = Eigen::Isometry3d::Identity();
  const auto first = std::find_if(samples.begin(), samples.end(), [](const Sample& sample) {
    return std::holds_alternative<GnssFix>(sample);
  });
  T_odom_vehicle.linear() = geometry::rotation_exp({0, 0, heading_of(std::get<GnssFix>(*first))});
  filter.set_pose(T_odom_vehicle, 0.01 * geometry::Matrix6::Identity());
  size_t minutes = 0;
  Stamp next = stamp_of(samples.front()) + from_seconds(60);
  for (auto sample = samples.begin(); sample != samples.end(); ++sample) {
    add(filter, *sample);
    if (stamp_of(*sample) < next) continue;
    next = stamp_of(*sample) + from_seconds(60);
    const auto end =
        std::find_if(sample, samples.end(), [&](const Sample& s) { return stamp_of(s) >= next; });
    if (end == samples.end()) break;
    next = next + from_seconds(60);
    const Outage outage = dead_reckon(filter, {sample + 1, end});
    std::cout << outage.distance << " m without GNSS: " << 100 * outage.position / outage.distance
              << " %, heading " << outage.heading / kDegree << "°\n";
    EXPECT_LT(outage.position, 0.015 * outage.distance);
    EXPECT_LT(std::abs(outage.heading), 1.5 * kDegree);
    ++minutes;
  }
  EXPECT_EQ(minutes, 9U);
  filter.flush();
  const OdometryReport report = filter.report();
  std::cout << "scale " << report.wheel_scale.value << " ± " << report.wheel_scale.sigma
            << ", delay of GNSS " << report.gnss_delay.value << " ± " << report.gnss_delay.sigma
            << " s, of the gyro " << report.imu_delay.value << " ± " << report.imu_delay.sigma
            << " s\n";
  EXPECT_NEAR(report.wheel_scale.value, 0.992, 0.002);
  EXPECT_NEAR(report.gnss_delay.value, 0.4, 3 * report.gnss_delay.sigma);
  EXPECT_LT(report.gnss_delay.sigma, 0.05);
}

}  // namespace
}  // namespace infuse::motion
