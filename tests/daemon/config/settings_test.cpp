#include "daemon/config/config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/measurement/angles.hpp"

namespace infuse::daemon {
namespace {

TEST(Config, OdometryAndCalibrationAreRead) {
  const auto config = parse_config(R"(
[odometry]
planar = false
wheelbase = 2.65
steering_ratio = 16.9
gnss_delay_ms = 120
reorder_ms = 150
use_gnss_speed = false
use_lidar = true
max_wait_ms = 50
[calibration]
monitor = false
policy = "apply-within"
limit_rotation_deg = 1.8
limit_translation = 0.05
)",
                                   "x.toml");
  ASSERT_TRUE(config) << config.error().message();
  EXPECT_EQ(config->odometry.planar, false);
  EXPECT_EQ(config->odometry.use_lidar, true);
  EXPECT_EQ(config->odometry.filter.wheelbase, 2.65);
  EXPECT_EQ(config->odometry.filter.gnss_delay, from_seconds(0.12));
  EXPECT_EQ(config->odometry.filter.reorder, from_seconds(0.15));
  EXPECT_FALSE(config->odometry.use_gnss_speed);
  EXPECT_EQ(config->odometry.max_wait, from_seconds(0.05));
  EXPECT_FALSE(config->calibration.monitored);
  EXPECT_EQ(config->calibration.supervisor.policy, monitoring::UpdatePolicy::kApplyWithin);
  EXPECT_NEAR(config->calibration.supervisor.limit_rotation, 0.0314159265, 1e-9);
  EXPECT_FALSE(parse_config("[calibration]\npolicy = \"sometimes\"\n", "x.toml"));
  EXPECT_FALSE(parse_config("[odometry]\nwheelbase = -1\n", "x.toml"));
  EXPECT_FALSE(parse_config("[odometry]\nmax_wait_ms = 1e9\n", "x.toml"));
}

TEST(Config, RecordIsReadAndChecked) {
  const auto config = parse_config(R"([record]
directory = "/data/drives"
memory_mb = 128
flight_recorder_s = 20
after_alert_s = 3
keep_alerts = 4
alert_pause_s = 60
budget_mb = 4096
max_duration_s = 600
max_size_mb = 2048
split_s = 60
split_mb = 512
min_free_mb = 100
)",
                                   "x.toml");
  ASSERT_TRUE(config) << config.error().message();
  RecordSettings expected;
  expected.directory = "/data/drives";
  expected.memory = 128 << 20;
  expected.flight_recorder = from_seconds(20);
  expected.after_alert = from_seconds(3);
  expected.keep_alerts = 4;
  expected.alert_pause = from_seconds(60);
  expected.budget = uint64_t{4096} << 20;
  expected.max_duration = from_seconds(600);
  expected.max_bytes = uint64_t{2048} << 20;
  expected.split = from_seconds(60);
  expected.split_bytes = 512 << 20;
  expected.min_free = 100 << 20;
  EXPECT_EQ(config->record, expected);
  EXPECT_EQ(parse_config("", "x.toml")->record, RecordSettings{});
  for (const char* wrong :
       {"memory_mb = 1", "flight_recorder_s = -1", "keep_alerts = 0", "alert_pause_s = -1",
        "budget_mb = 0", "max_duration_s = 0", "max_size_mb = 0", "split_s = 0.1",
        "min_free_mb = -1", "max_size_mb = 9223372036854775807", "folder = \"x\""}) {
    EXPECT_FALSE(parse_config(std::string("[record]\n") + wrong, "x.toml")) << wrong;
  }
}

TEST(Config, MetricsAreDisabledByDefault) {
  EXPECT_FALSE(parse_config("", "x.toml")->metrics.enabled());
  const auto config = parse_config("[metrics]\npath = \"/run/m\"\nport = 9469\n", "x.toml");
  ASSERT_TRUE(config);
  EXPECT_EQ(config->metrics, (MetricsSettings{"/run/m", 9469}));
  EXPECT_FALSE(parse_config("[metrics]\npath = \"m\"\n", "x.toml"));
  EXPECT_FALSE(parse_config("[metrics]\nport = 70000\n", "x.toml"));
}

TEST(Config, ABrokerHasAVehicleAndWholeCertificates) {
  EXPECT_FALSE(parse_config("", "x.toml")->mqtt.enabled());
  const auto parse = [](const std::string& more) {
    return parse_config("[mqtt]\nhost = \"broker.example\"\n" + more, "x.toml");
  };
  const auto config = parse("vehicle = \"car7\"\nca_file = \"ca.pem\"\nqueue_mb = 8\n");
  ASSERT_TRUE(config) << config.error().message();
  EXPECT_EQ(config->mqtt.port_or_default(), 8883);
  EXPECT_EQ(config->mqtt.queue, 8U << 20);
  EXPECT_EQ(parse("vehicle = \"car7\"\n")->mqtt.port_or_default(), 1883);
  for (const char* wrong :
       {"", "vehicle = \"a/b\"", "vehicle = \"a+\"", "vehicle = \"a\"\ntopic = \"/x\"",
        "vehicle = \"a\"\ntopic = \"x/#\"", "vehicle = \"a\"\nkey_file = \"k\"",
        "vehicle = \"a\"\nqueue_mb = 0", "vehicle = \"a\"\npose_interval_s = -1",
        "vehicle = \"a\"\npassword_file = \"p\"", "vehicle = \"a\"\nport = 70000",
        "vehicle = \"a\"\nhost_name = \"b\""}) {
    EXPECT_FALSE(parse(wrong)) << wrong;
  }
  EXPECT_FALSE(parse_config("[mqtt]\nvehicle = \"car7\"\n", "x.toml"));
}

TEST(Config, ABrokerThatTheUnitMayDenyIsADoubt) {
  const auto doubt = [](const std::string& host) {
    return find_broker_doubt({.host = host, .vehicle = "car7"});
  };
  EXPECT_FALSE(doubt(""));
  for (const char* host : {"localhost", "127.0.0.1", "10.1.2.3", "172.16.0.1", "172.31.255.1",
                           "192.168.1.1", "169.254.3.4"}) {
    EXPECT_FALSE(doubt(host)) << host;
  }
  for (const char* host : {"broker.example", "8.8.8.8", "172.32.0.1", "::1", "fd00::1"}) {
    EXPECT_TRUE(doubt(host)) << host;
  }
}

TEST(Config, AHeadingThatIsNotStatedIsUnknown) {
  for (const char* place : {"x = 3\ny = 4\n", "lat = 49\nlon = 8\n"}) {
    const auto config = parse_config(std::string("[streetmap]\n") + place, "c.toml");
    ASSERT_TRUE(config) << config.error().message();
    const streetmap::MapFrame frame{
        .georeferenced = true, .latitude = 49 * kDegree, .longitude = 8 * kDegree};
    const auto start = stated_start(config->streetmap, frame);
    ASSERT_TRUE(start);
    EXPECT_NEAR(start->yaw_sigma, 180 * kDegree / std::sqrt(3), 1e-9);  // uniform over ± 180°
  }
}

TEST(Config, TheStreetMapIsReadAndChecked) {
  const auto config = parse_config(
      "[streetmap]\nmap = \"town.map\"\nx = 12.5\ny = -3\nyaw_deg = 90\nsigma = 4\n"
      "yaw_sigma_deg = 5\nupdate_hz = 5\nseed = 7\n",
      "c.toml");
  ASSERT_TRUE(config) << config.error().message();
  const StreetMapSettings& settings = config->streetmap;
  EXPECT_EQ(settings.map, "town.map");
  ASSERT_TRUE(settings.initial_pose);
  EXPECT_EQ(settings.initial_pose->x, 12.5);
  EXPECT_EQ(settings.initial_pose->y, -3);
  EXPECT_NEAR(settings.initial_pose->yaw.value(), 1.5707963, 1e-6);
  EXPECT_EQ(settings.initial_sigma, 4);
  EXPECT_NEAR(settings.initial_yaw_sigma, 0.0872665, 1e-6);
  EXPECT_EQ(settings.update_hz, 5);
  EXPECT_EQ(settings.tracker.seed, 7U);
  const auto located = parse_config(
      "[streetmap]\nlat = 49\nlon = 8.4\nheading_deg = 180\nrequire_tracking = false\n"
      "global_start = false\n",
      "c.toml");
  ASSERT_TRUE(located) << located.error().message();
  ASSERT_TRUE(located->streetmap.initial_location);
  EXPECT_NEAR(located->streetmap.initial_location->latitude, 0.8552113, 1e-6);
  EXPECT_NEAR(located->streetmap.initial_location->longitude, 0.1466077, 1e-6);
  EXPECT_NEAR(located->streetmap.initial_location->heading.value(), 3.1415927, 1e-6);
  EXPECT_FALSE(located->streetmap.require_tracking);
  EXPECT_FALSE(located->streetmap.tracker.global_start.enabled);
  EXPECT_TRUE(settings.tracker.global_start.enabled);
  EXPECT_TRUE(settings.require_tracking);
  EXPECT_FALSE(parse_config("[streetmap]\nlat = 49\n", "c.toml"));
  EXPECT_FALSE(parse_config("[streetmap]\nlat = 91\nlon = 8\n", "c.toml"));
  EXPECT_FALSE(parse_config("[streetmap]\nlat = 49\nlon = 8\nx = 1\ny = 2\n", "c.toml"));
  EXPECT_FALSE(parse_config("[streetmap]\nx = 1\n", "c.toml"));
  EXPECT_FALSE(parse_config("[streetmap]\nupdate_hz = 0\n", "c.toml"));
  EXPECT_FALSE(parse_config("[streetmap]\nmpa = \"x\"\n", "c.toml"));
}

TEST(Config, AMapIsReadAndNotUsedTogetherWithAStreetMap) {
  const auto config = parse_config("[map]\ndirectory = \"town\"\nlidar = \"top\"\n", "c.toml");
  ASSERT_TRUE(config) << config.error().message();
  EXPECT_EQ(config->map.directory, "town");
  EXPECT_EQ(config->map.lidar, "top");
  EXPECT_FALSE(parse_config("[map]\nlidar = \"top\"\n", "c.toml"));
  const auto both =
      parse_config("[map]\ndirectory = \"town\"\n[streetmap]\nmap = \"town.map\"\n", "c.toml");
  ASSERT_FALSE(both);
  EXPECT_THAT(both.error().message(), testing::HasSubstr("[map] and [streetmap]"));
}

}  // namespace
}  // namespace infuse::daemon
