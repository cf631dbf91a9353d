// The gyros in a lidar's housing become a source of odometry once the lidar's motion shows which
// axes they measure.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "daemon/pipeline/odometry_tracker.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"
#include "fixtures/velodyne/position_encoder.hpp"
#include "tests/daemon/pipeline/run_replay.hpp"
#include "tests/fusion/motion/simulated_sensors.hpp"
#include "tests/real_data.hpp"

namespace infuse::daemon {
namespace {

using motion::seconds;

/// Readings that an intake returns for a position packet with raw gyro values 1, −2 and 2047.
std::vector<GyroReadings> readings_of(velodyne::Model model) {
  LidarSetup setup;
  setup.decoder.model = &velodyne::lidar_model(model);
  LidarIntake intake(setup);
  std::vector<GyroReadings> out;
  velodyne::PositionPacketFields fields;
  fields.imu[0][0] = 1;
  fields.imu[1][0] = -2;
  fields.imu[2][0] = 2047;
  const auto packet = velodyne::encode_position_packet(fields);
  intake.add_datagram(
      {Stamp::from_ns(5), 7, 8308, 8308, packet}, [](Sweep&) {}, [](const GnssFix&) {},
      [&](const GyroReadings& readings) { out.push_back(readings); }, [](const ImuSample&) {});
  return out;
}

TEST(LidarGyros, OfAnHdl32eAreRead) {
  const auto readings = readings_of(velodyne::Model::kHdl32e);
  ASSERT_EQ(readings.size(), 1U);
  EXPECT_EQ(readings[0].stamp, Stamp::from_ns(5));
  EXPECT_NEAR(readings[0].rate[0], 0.0017045, 1e-6);
  EXPECT_NEAR(readings[0].rate[1], -2 * 0.0017045, 1e-6);
  EXPECT_NEAR(readings[0].rate[2], 3.48908, 1e-4);
  EXPECT_TRUE(readings_of(velodyne::Model::kVlp16).empty());
}

uint64_t accepted_gyros(const OdometryTracker& odometry, double now) {
  const OdometryStatus status = odometry.status(seconds(now));
  return status.sources[static_cast<size_t>(motion::OdometrySource::kGyro)].accepted;
}

/// Drives half a minute through a town, with sweeps at 10 Hz, then `silent` seconds without any.
/// Returns the error of the heading over that time, rad.
double heading_error(OdometryTracker& odometry, double silent, bool gyros, bool inertial_unit) {
  constexpr double kSighted = 30;
  const motion::TrueDrive drive(kSighted + silent + 1, [](double t) {
    geometry::Vector6 twist;
    twist << 0.05 * std::sin(5.1 * t), 0.04 * std::sin(6.3 * t), 0.3 * std::sin(0.5 * t), 10, 0, 0;
    return twist;
  });
  motion::SimulatedSensors sensors(drive, 3);
  std::mt19937_64 random(8);
  std::normal_distribution<double> normal(0, 0.02);
  odometry.mark(seconds(0), true);
  odometry.process_until(seconds(0));
  for (int i = 1; i <= std::lround((kSighted + silent) / 0.005); ++i) {
    const double t = 0.005 * i;
    const geometry::Vector6 twist = drive.twist(t);
    if (gyros) {
      // The first measures −z, the second x, the third −y.
      odometry.add(GyroReadings{seconds(t),
                                {-twist[2] - 0.51 + normal(random), twist[0] + 0.1 + normal(random),
                                 -twist[1] - 0.06 + normal(random)}});
    }
    if (inertial_unit) odometry.add(sensors.gyro(t, Eigen::Vector3d::Zero()));
    if (i % 20 != 0 || t > kSighted) continue;
    odometry.mark(seconds(t), true);
    odometry.process_until(seconds(t));
    odometry.add(sensors.lidar(t - 0.1, t));
  }
  odometry.mark(seconds(kSighted + silent), false);
  odometry.process_until(seconds(kSighted + silent));
  const auto found = odometry.trajectory().between(seconds(kSighted), seconds(kSighted + silent));
  EXPECT_TRUE(found.usable()) << found.reason;
  const Eigen::Isometry3d truth = drive.pose(kSighted).inverse() * drive.pose(kSighted + silent);
  return geometry::rotation_log(found.T_from_to.linear().transpose() * truth.linear()).norm();
}

TEST(LidarGyros, CarryTheRotationWhileTheLidarIsSilent) {
  OdometryTracker with({.use_lidar = true}), without({.use_lidar = true});
  const double error = heading_error(with, 0.45, true, false);
  EXPECT_GT(accepted_gyros(with, 30.4), 1000U);
  EXPECT_LT(error, 0.006);
  EXPECT_GT(heading_error(without, 0.45, false, false), 2 * error);
  for (size_t gyro = 0; gyro < 3; ++gyro) EXPECT_TRUE(with.gyro_axes().axes()[gyro].known());
  EXPECT_EQ(with.gyro_axes().axes()[0].axis, 2);
  EXPECT_EQ(with.gyro_axes().axes()[0].sign, -1);
}

TEST(LidarGyros, AnInertialUnitTakesTheirPlace) {
  OdometryTracker both({.use_lidar = true}), unit({.use_lidar = true});
  const double error = heading_error(both, 0.2, true, true);
  EXPECT_EQ(error, heading_error(unit, 0.2, false, true));
  EXPECT_EQ(accepted_gyros(both, 30.1), accepted_gyros(unit, 30.1));
}

// Five turns of the lidar on a straight road tell nothing.
TEST(LidarGyros, RealHdl32ECaptureShowsNoAxis) {
  INFUSE_REAL_DATA_OR_SKIP(path, "velodyne/hdl32e-moving.pcap");
  const auto result = run_replay(path);
  ASSERT_TRUE(result) << result.error().message();
  size_t listed = 0;
  for (const std::string& line : result->lines()) {
    const auto report = nlohmann::json::parse(line);
    if (report["class"] != "HEALTH") continue;
    for (const auto& source : report["odometry"]["sources"]) {
      listed += source["name"] == "lidar" ? 1 : 0;
      if (source["name"] != "gyro") continue;
      EXPECT_EQ(source["accepted"], 0);
      EXPECT_EQ(source["carries"], false);
    }
  }
  EXPECT_GT(listed, 0U);
}

}  // namespace
}  // namespace infuse::daemon
