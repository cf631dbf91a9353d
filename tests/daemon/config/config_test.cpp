#include "daemon/config/config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <random>

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

constexpr const char* kFull = R"(log_level = "debug"

[socket]
path = "/tmp/x.sock"
tcp_port = 2947
max_clients = 8
idle_timeout_s = 1.5
queue_reports = 16
max_requests_hz = 10

[health]
stale_after_s = 2
raise_after_s = 0.5
clear_after_s = 4
clock_grace_s = 20
warn_loss = 0.01
error_loss = 0.1

[[lidar]]
name = "front"
model = "HDL-32E"
port = 2370
sender = "192.168.1.201"
)";

TEST(Config, AnEmptyFileGivesTheDefaults) {
  const auto config = parse_config("", "x.toml");
  ASSERT_TRUE(config);
  EXPECT_EQ(config->socket.max_clients, 64U);
  EXPECT_EQ(config->health.stale_after, from_seconds(3));
  EXPECT_TRUE(config->lidars.empty());
}

constexpr const char* kLive = R"(rig = "rig.toml"
[[lidar]]
model = "VLP-16"
position_port = 8309
address = "10.0.0.1"
multicast = "239.1.1.1"
interface = "eth1"
receive_buffer_bytes = 4194304

[[camera]]
name = "front"
device = "/dev/v4l/by-id/front"
width = 1280
height = 720
rate_hz = 25
format = "UYVY"
exposure_ms = 5
gain = 12
stamp_delay_ms = -1.5

[[can]]
interface = "can1"
dbc = "car.dbc"
reverse_gear = 7
[can.signals]
yaw_rate = "ESP.YAW"
wheel_speed_rear_left = { signal = "ABS.RL", scale = -1, unit = "km/h" }

[gnss]
device = "/dev/ttyUSB3"
baud = 115200
)";

TEST(Config, LiveSensorsAreRead) {
  const auto config = parse_config(kLive, "x.toml");
  ASSERT_TRUE(config) << config.error().message();
  EXPECT_EQ(config->rig, "rig.toml");
  ASSERT_EQ(config->lidars.size(), 1U);
  const velodyne::UdpOptions udp = config->lidars[0].udp(8309);
  EXPECT_EQ(udp.port, 8309);
  EXPECT_EQ(udp.address, "10.0.0.1");
  EXPECT_EQ(udp.multicast, "239.1.1.1");
  EXPECT_EQ(udp.interface, "eth1");
  EXPECT_EQ(udp.receive_buffer, 4194304U);
  ASSERT_EQ(config->cameras.size(), 1U);
  const camera::V4l2Options& stream = config->cameras[0].stream;
  EXPECT_EQ(config->cameras[0].name, "front");
  EXPECT_EQ(stream.device, "/dev/v4l/by-id/front");
  EXPECT_EQ(stream.width, 1280);
  EXPECT_EQ(stream.height, 720);
  EXPECT_EQ(stream.rate_hz, 25);
  EXPECT_EQ(stream.format, camera::RawFormat::kUyvy);
  EXPECT_EQ(stream.exposure, from_seconds(0.005));
  EXPECT_EQ(stream.gain, 12);
  EXPECT_EQ(stream.stamp_delay, from_seconds(-0.0015));
  ASSERT_EQ(config->buses.size(), 1U);
  EXPECT_EQ(config->buses[0].interface, "can1");
  EXPECT_EQ(config->buses[0].dbc, "car.dbc");
  EXPECT_EQ(config->buses[0].reverse_gear, 7);
  ASSERT_EQ(config->buses[0].signals.size(), 2U);
  EXPECT_EQ(config->buses[0].signals[0].quantity, "wheel_speed_rear_left");
  EXPECT_EQ(config->buses[0].signals[0].scale, -1);
  EXPECT_EQ(config->gnss.device, "/dev/ttyUSB3");
  EXPECT_EQ(config->gnss.baud, 115200U);
}

TEST(Config, ATapIsAnOptionOfTheInterface) {
  const auto config = parse_config("[[lidar]]\ninterface = \"eth1\"\ntap = true", "x.toml");
  ASSERT_TRUE(config) << config.error().message();
  EXPECT_TRUE(config->lidars[0].udp(2368).tap);
  EXPECT_EQ(config->lidars[0].udp(2368).interface, "eth1");
}

TEST(Config, AnInvalidLiveSensorIsAnErrorWithItsLine) {
  for (const char* text :
       {"[[camera]]\ndevice = \"video0\"", "[[camera]]\nwidth = 640",
        "[[camera]]\nformat = \"H264\"", "[[camera]]\nexposure_ms = 0", "[[can]]\ninterface = \"\"",
        "[[can]]\nsignals = {yaw_rate = \"A.B\"}",
        "[[can]]\ndbc = \"x\"\nsignals = {yaw = \"A.B\"}", "[gnss]\ndevice = \"/dev/x\"\nbaud = 1",
        "[gnss]\ndevice = \"/dev/x\"\nlidar = \"top\"", "[[lidar]]\nmulticast = \"10.0.0.1\"",
        "[[lidar]]\ntap = true", "[[lidar]]\nposition_port = 0",
        "[[camera]]\nname = \"a\"\n[[camera]]\nname = \"a\""}) {
    const auto config = parse_config(text, "x.toml");
    ASSERT_FALSE(config) << text;
    EXPECT_THAT(config.error().where, HasSubstr("x.toml:")) << text;
  }
}

/// A configuration and its drop-ins in a temporary folder.
struct ConfigFolder {
  std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("infuse-config-" + std::to_string(getpid()));
  std::filesystem::path file = folder / "infused.toml";

  ConfigFolder() { std::filesystem::create_directories(folder / "infused.toml.d"); }
  ~ConfigFolder() { std::filesystem::remove_all(folder); }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder / name) << text;
  }
};

TEST(Config, DropInsChangeAndAddInOrderOfTheirNames) {
  const ConfigFolder folder;
  folder.write("infused.toml",
               "log_level = \"debug\"\n[[lidar]]\nname = \"a\"\nport = 2000\n"
               "model = \"VLP-16\"\n[socket]\nmax_clients = 3\n");
  folder.write("infused.toml.d/20-second.toml", "[[lidar]]\nname = \"a\"\nport = 2002\n");
  folder.write("infused.toml.d/10-first.toml",
               "[[lidar]]\nname = \"a\"\nport = 2001\n[[lidar]]\nname = \"b\"\nport = 2010\n"
               "[socket]\nqueue_reports = 7\n");
  folder.write("infused.toml.d/README", "not read");
  const auto config = load_config(folder.file);
  ASSERT_TRUE(config) << config.error().message();
  EXPECT_EQ(config->log_level, "debug");
  ASSERT_EQ(config->lidars.size(), 2U);
  EXPECT_EQ(config->lidars[0].port, 2002);
  EXPECT_EQ(config->lidars[0].model, "VLP-16");
  EXPECT_EQ(config->lidars[1].name, "b");
  EXPECT_EQ(config->socket.max_clients, 3U);
  EXPECT_EQ(config->socket.queue_reports, 7U);
  EXPECT_EQ(config->resolve("rig.toml"), folder.folder / "rig.toml");
}

TEST(Config, AnErrorNamesItsDropIn) {
  const ConfigFolder folder;
  folder.write("infused.toml", "");
  folder.write("infused.toml.d/x.toml", "\n\nportt = 1\n");
  const auto config = load_config(folder.file);
  ASSERT_FALSE(config);
  EXPECT_THAT(config.error().where, HasSubstr("x.toml:3"));
}

TEST(Config, EveryKeyIsRead) {
  const auto config = parse_config(kFull, "x.toml");
  ASSERT_TRUE(config) << config.error().message();
  EXPECT_EQ(config->log_level, "debug");
  EXPECT_EQ(config->socket.path, "/tmp/x.sock");
  EXPECT_EQ(config->socket.tcp_port, 2947);
  EXPECT_EQ(config->socket.max_clients, 8U);
  EXPECT_EQ(config->socket.idle_timeout, from_seconds(1.5));
  EXPECT_EQ(config->socket.queue_reports, 16U);
  EXPECT_EQ(config->socket.max_requests_hz, 10);
  EXPECT_EQ(config->health.stale_after, from_seconds(2));
  EXPECT_EQ(config->health.raise_after, from_seconds(0.5));
  EXPECT_EQ(config->health.clear_after, from_seconds(4));
  EXPECT_EQ(config->health.clock_grace, from_seconds(20));
  EXPECT_EQ(config->health.warn_loss, 0.01);
  EXPECT_EQ(config->health.error_loss, 0.1);
  ASSERT_EQ(config->lidars.size(), 1U);
  EXPECT_EQ(config->lidars[0].name, "front");
  EXPECT_EQ(config->lidars[0].model, "HDL-32E");
  EXPECT_EQ(config->lidars[0].port, 2370);
  EXPECT_EQ(config->lidars[0].sender, "192.168.1.201");
}

struct Wrong {
  const char* text;
  const char* message;
};

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

TEST(Config, ListsTheKeysThatDiffer) {
  const auto read = [](const char* text) {
    auto config = parse_config(text, "x.toml");
    EXPECT_TRUE(config) << config.error().message();
    return config.value_or(Config{});
  };
  const char* one = "log_level = \"info\"\n[health]\nwarn_loss = 0.01\n[[lidar]]\nport = 1\n";
  EXPECT_TRUE(changed_keys(read(one), read(one)).empty());
  const char* spaced = "# why\nlog_level='info'\n\n[health]\nwarn_loss=0.01\n[[lidar]]\nport=1\n";
  EXPECT_TRUE(changed_keys(read(one), read(spaced)).empty());
  EXPECT_THAT(changed_keys(read(one), read("[health]\nwarn_loss = 0.01\n[[lidar]]\nport = 2\n")),
              testing::ElementsAre("lidar", "log_level"));
  EXPECT_THAT(changed_keys(read(""), read("rig = \"r\"\n")), testing::ElementsAre("rig"));
}

TEST(Config, ErrorsNameTheLineAndTheProblem) {
  const Wrong cases[] = {
      {"\n[health]\nstale_after = 3\n", "x.toml:3: unknown key 'stale_after'"},
      {"\n[health]\nstale_after = 3\n", "known keys: stale_after_s, raise_after_s"},
      {"[socket]\npath = 3", "x.toml:2: path must be a string in quotes"},
      {"[socket]\nmax_clients = 1.5", "x.toml:2: max_clients must be an integer"},
      {"[socket]\ntcp_port = 65536", "tcp_port must be an integer from 0 to 65535"},
      {"[socket]\nmax_clients = 0", "x.toml:1: socket: max_clients must lie in"},
      {"[health]\nwarn_loss = \"1\"", "x.toml:2: warn_loss must be a number"},
      {"[health]\nwarn_loss = nan", "warn_loss must be a finite number"},
      {"socket = 1", "socket must be a table"},
      {"lidar = 1", "tables: [[lidar]]"},
      {"lidar = [1]", "tables: [[lidar]]"},
      {"[[lidar]]\n[[lidar]]", "x.toml:2: two lidars are named 'lidar'"},
      {"log_level = \"loud\"", "log_level is none of"},
      {"a = = 1", "x.toml:1:"},
      {"[socket\n", "x.toml:1:"}};
  for (const Wrong& wrong : cases) {
    const auto config = parse_config(wrong.text, "x.toml");
    ASSERT_FALSE(config) << wrong.text;
    EXPECT_THAT(config.error().message(), HasSubstr(wrong.message));
  }
}

TEST(Config, AMissingFileIsAnError) {
  const auto config = load_config("/nonexistent/infused.toml");
  ASSERT_FALSE(config);
  EXPECT_EQ(config.error().where, "/nonexistent/infused.toml");
  EXPECT_FALSE(load_config("/"));
}

TEST(Config, TheStreetMapIsReadAndChecked) {
  const auto config = parse_config(
      "[streetmap]\nmap = \"town.map\"\nx = 12.5\ny = -3\nyaw_deg = 90\nsigma = 4\n"
      "yaw_sigma_deg = 5\nupdate_hz = 5\nsearch_radius = 20\nseed = 7\n",
      "c.toml");
  ASSERT_TRUE(config) << config.error().message();
  const StreetMapSettings& settings = config->streetmap;
  EXPECT_EQ(settings.map, "town.map");
  ASSERT_TRUE(settings.initial_pose);
  EXPECT_EQ(settings.initial_pose->x, 12.5);
  EXPECT_EQ(settings.initial_pose->y, -3);
  EXPECT_NEAR(settings.initial_pose->yaw, 1.5707963, 1e-6);
  EXPECT_EQ(settings.initial_sigma, 4);
  EXPECT_NEAR(settings.initial_yaw_sigma, 0.0872665, 1e-6);
  EXPECT_EQ(settings.update_hz, 5);
  EXPECT_EQ(settings.tracker.confidence.search_radius, 20);
  EXPECT_EQ(settings.tracker.seed, 7U);
  const auto located = parse_config(
      "[streetmap]\nlat = 49\nlon = 8.4\nheading_deg = 180\nrequire_tracking = false\n"
      "global_start = false\n",
      "c.toml");
  ASSERT_TRUE(located) << located.error().message();
  ASSERT_TRUE(located->streetmap.initial_location);
  EXPECT_NEAR(located->streetmap.initial_location->latitude, 0.8552113, 1e-6);
  EXPECT_NEAR(located->streetmap.initial_location->longitude, 0.1466077, 1e-6);
  EXPECT_NEAR(located->streetmap.initial_location->heading, 3.1415927, 1e-6);
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

TEST(Config, SizeAndDepthAreBounded) {
  EXPECT_FALSE(parse_config(std::string(2 << 20, '\n'), "x.toml"));
  EXPECT_FALSE(parse_config("a = " + std::string(100'000, '['), "x.toml"));
}

TEST(Config, TenThousandMutatedFilesAreEachReadOrRefusedWithAReason) {
  std::mt19937 random(2);
  int refused = 0;
  for (int i = 0; i < 10'000; ++i) {
    std::string text = kFull;
    for (unsigned edits = 1 + random() % 4; edits > 0; --edits) {
      const size_t place = random() % text.size();
      if (random() % 2 == 0) {
        text[place] = static_cast<char>(random());
      } else {
        text.erase(place, random() % 8);
      }
    }
    const auto config = parse_config(text, "x.toml");
    if (config) continue;
    ++refused;
    EXPECT_THAT(config.error().where, testing::StartsWith("x.toml"));
    EXPECT_FALSE(config.error().what.empty());
  }
  EXPECT_GT(refused, 5000);
  EXPECT_LT(refused, 10'000);
}

}  // namespace
}  // namespace infuse::daemon
