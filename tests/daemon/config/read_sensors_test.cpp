#include "daemon/config/config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

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
  const lidar::UdpOptions udp = config->lidars[0].udp(8309);
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

TEST(Config, AnUnknownModelIsAnErrorThatNamesTheKnownOnes) {
  const auto config = parse_config("[[lidar]]\nmodel = \"Mid-360\"\n", "x.toml");
  ASSERT_FALSE(config);
  EXPECT_THAT(config.error().message(), HasSubstr("unknown model 'Mid-360' (known: "));
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

}  // namespace
}  // namespace infuse::daemon
