#include "drivers/vehicle/signal_map.hpp"
#include "drivers/measurement/angles.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "drivers/vehicle/candump.hpp"
#include "tests/real_data.hpp"

namespace infuse::vehicle {
namespace {

using testing::HasSubstr;

constexpr char kDbc[] = R"(BO_ 100 WHEELS: 8 X
 SG_ FL : 0|16@1+ (0.01,0) [0|0] "km/h" X
 SG_ FR : 16|16@1+ (0.01,0) [0|0] "km/h" X
 SG_ RL : 32|16@1+ (0.01,0) [0|0] "km/h" X
 SG_ RR : 48|16@1+ (0.01,0) [0|0] "km/h" X
BO_ 101 DYNAMICS: 8 X
 SG_ YAW : 0|16@1- (0.01,0) [0|0] "deg/s" X
 SG_ ACCEL : 16|16@1- (0.001,0) [0|0] "g" X
 SG_ COARSE : 32|8@1- (1.5,0) [0|0] "deg" X
 SG_ FINE : 40|8@1- (0.1,0) [0|0] "deg" X
 SG_ BARE : 48|8@1- (0.1,0) [0|0] "" X
BO_ 102 GEARBOX: 1 X
 SG_ GEAR : 0|8@1+ (1,0) [0|0] "" X
BO_ 2024 OBD: 8 X
 SG_ PID M : 16|8@1+ (1,0) [0|0] "" X
 SG_ SPEED m13 : 24|8@1+ (1,0) [0|0] "km/h" X
)";

SignalMap make_map() {
  SignalMap make_map;
  make_map.wheel_speed = {SignalSource{"WHEELS.FL"}, SignalSource{"WHEELS.FR"},
                          SignalSource{"WHEELS.RL"}, SignalSource{"WHEELS.RR"}};
  make_map.yaw_rate = {"DYNAMICS.YAW", -1, ""};
  make_map.steering_angle = {"DYNAMICS.COARSE"};
  make_map.steering_fraction = {"DYNAMICS.FINE"};
  make_map.acceleration[0] = {"DYNAMICS.ACCEL"};
  make_map.gear = {"GEARBOX.GEAR"};
  make_map.reverse_gear = 7;
  return make_map;
}

CanFrame make_test_frame(uint32_t id, std::initializer_list<uint8_t> bytes) {
  CanFrame made;
  made.stamp = Stamp::from_ns(5);
  made.id = id;
  made.length = static_cast<uint8_t>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), made.data.begin());
  return made;
}

TEST(SignalMap, ReturnsSamplesInSiUnits) {
  auto decoder = VehicleDecoder::create(parse_dbc(kDbc, "x").dbc, make_map());
  ASSERT_TRUE(decoder) << decoder.error().message();
  const auto wheels =
      decoder->decode(make_test_frame(100, {0x10, 0x0E, 0, 0, 1, 0, 2, 0}));  // 36 km/h
  ASSERT_TRUE(wheels.wheels);
  EXPECT_FALSE(wheels.imu);
  EXPECT_EQ(wheels.wheels->stamp.ns(), 5);
  EXPECT_NEAR(wheels.wheels->wheel_speed[0], 10, 1e-12);
  EXPECT_NEAR(wheels.wheels->wheel_speed[3], 0.02 / 3.6, 1e-12);
  EXPECT_TRUE(std::isnan(wheels.wheels->yaw_rate));

  const auto dynamics =
      decoder->decode(make_test_frame(101, {0xE8, 0x03, 0xE8, 0x03, 2, 0xFF, 0, 0}));
  ASSERT_TRUE(dynamics.wheels && dynamics.imu);
  EXPECT_NEAR(dynamics.wheels->yaw_rate, -10 * kDegree, 1e-12) << "the scale turns the sign";
  EXPECT_NEAR(dynamics.wheels->steering_angle, 2.9 * kDegree, 1e-12);
  EXPECT_TRUE(std::isnan(dynamics.wheels->wheel_speed[2]));
  EXPECT_NEAR(dynamics.imu->linear_acceleration[0], 9.80665, 1e-12);
  EXPECT_TRUE(std::isnan(dynamics.imu->linear_acceleration[1]));
  EXPECT_TRUE(std::isnan(dynamics.imu->angular_velocity[2]));
}

TEST(SignalMap, NegatesWheelSpeedsInReverse) {
  auto decoder = VehicleDecoder::create(parse_dbc(kDbc, "x").dbc, make_map());
  ASSERT_TRUE(decoder);
  const auto wheels = make_test_frame(100, {0x10, 0x0E, 0, 0, 0, 0, 0, 0});
  EXPECT_FALSE(decoder->decode(make_test_frame(102, {7})).wheels);
  EXPECT_NEAR(decoder->decode(wheels).wheels->wheel_speed[0], -10, 1e-12);
  decoder->decode(make_test_frame(102, {3}));
  EXPECT_NEAR(decoder->decode(wheels).wheels->wheel_speed[0], 10, 1e-12);
}

// OBD-II: the answer to request 13.
TEST(SignalMap, ReturnsOneSpeedOfTheVehicle) {
  SignalMap map;
  map.speed = {"OBD.SPEED"};
  auto decoder = VehicleDecoder::create(parse_dbc(kDbc, "x").dbc, map);
  ASSERT_TRUE(decoder) << decoder.error().message();
  const auto answer = decoder->decode(make_test_frame(0x7E8, {3, 0x41, 13, 36, 0, 0, 0, 0}));
  ASSERT_TRUE(answer.wheels);
  EXPECT_NEAR(answer.wheels->speed, 10, 1e-12);
  EXPECT_TRUE(std::isnan(answer.wheels->wheel_speed[0]));
  EXPECT_FALSE(decoder->decode(make_test_frame(0x7E8, {3, 0x41, 5, 36, 0, 0, 0, 0})).wheels);
}

TEST(SignalMap, IgnoresOtherInterfacesAndFrames) {
  SignalMap one_bus = make_map();
  one_bus.interface = "can0";
  auto decoder = VehicleDecoder::create(parse_dbc(kDbc, "x").dbc, one_bus);
  ASSERT_TRUE(decoder);
  CanFrame wheels = make_test_frame(100, {0x10, 0x0E, 0, 0, 0, 0, 0, 0});
  wheels.set_interface("can128");
  EXPECT_FALSE(decoder->decode(wheels).wheels);
  wheels.set_interface("can0");
  EXPECT_TRUE(decoder->decode(wheels).wheels);
  wheels.extended = true;
  EXPECT_FALSE(decoder->decode(wheels).wheels);
  wheels.extended = false;
  wheels.error = true;
  EXPECT_FALSE(decoder->decode(wheels).wheels);
  wheels.error = false;
  wheels.length = 3;
  const auto cut = decoder->decode(wheels);
  ASSERT_TRUE(cut.wheels);
  EXPECT_NEAR(cut.wheels->wheel_speed[0], 10, 1e-12);
  EXPECT_TRUE(std::isnan(cut.wheels->wheel_speed[1]));
}

TEST(SignalMap, ReportsInvalidMaps) {
  const Dbc dbc = parse_dbc(kDbc, "x").dbc;
  const auto error_of = [&](auto&& change) {
    SignalMap changed = make_map();
    change(changed);
    const auto decoder = VehicleDecoder::create(dbc, changed);
    return decoder ? std::string() : decoder.error().message();
  };
  EXPECT_EQ(error_of([](SignalMap&) {}), "");
  EXPECT_THAT(error_of([](SignalMap& m) { m.yaw_rate.signal = "YAW"; }),
              HasSubstr("'YAW' must be MESSAGE.SIGNAL"));
  EXPECT_THAT(error_of([](SignalMap& m) { m.yaw_rate.signal = "NONE.YAW"; }),
              HasSubstr("no signal NONE.YAW (it has no message of that name)"));
  EXPECT_THAT(error_of([](SignalMap& m) { m.yaw_rate.signal = "DYNAMICS.JAW"; }),
              HasSubstr("no signal DYNAMICS.JAW"));
  EXPECT_THAT(error_of([](SignalMap& m) { m.yaw_rate.signal = "DYNAMICS.BARE"; }),
              HasSubstr("set `unit` to rad/s or deg/s"));
  EXPECT_EQ(error_of([](SignalMap& m) { m.yaw_rate = {"DYNAMICS.BARE", 1, "rad/s"}; }), "");
  EXPECT_THAT(error_of([](SignalMap& m) { m.yaw_rate.scale = 0; }), HasSubstr("scale"));
  EXPECT_THAT(error_of([](SignalMap& m) { m.steering_angle.signal = ""; }),
              HasSubstr("steering_fraction needs steering_angle"));
  EXPECT_THAT(error_of([](SignalMap& m) { m.gear.signal = ""; }), HasSubstr("needs gear"));
  EXPECT_THAT(error_of([](SignalMap& m) { m = {}; }), HasSubstr("no signal is configured"));
}

TEST(SignalMap, RealRav4WheelSpeedsEqualTheTable) {
  INFUSE_REAL_DATA_OR_SKIP(path, "can/rav4");
  const auto dbc = read_dbc(path / "vehicle.dbc");
  ASSERT_TRUE(dbc);
  SignalMap rav4;
  rav4.interface = "can0";
  rav4.wheel_speed = {
      SignalSource{"WHEEL_SPEEDS.WHEEL_SPEED_FL"}, SignalSource{"WHEEL_SPEEDS.WHEEL_SPEED_FR"},
      SignalSource{"WHEEL_SPEEDS.WHEEL_SPEED_RL"}, SignalSource{"WHEEL_SPEEDS.WHEEL_SPEED_RR"}};
  rav4.yaw_rate = {"KINEMATICS.YAW_RATE"};
  auto decoder = VehicleDecoder::create(dbc->dbc, rav4);
  ASSERT_TRUE(decoder) << decoder.error().message();

  std::ifstream log(path / "raw_can_candump.log"), table(path / "wheel_speed.csv");
  CandumpReader reader("raw_can_candump.log");
  std::string line, row;
  std::getline(table, row);
  size_t equal = 0;
  while (std::getline(log, line)) {
    const auto can = reader.read(line);
    if (!can || can->id != 0xAA) continue;
    const auto samples = decoder->decode(*can);
    if (!samples.wheels) continue;
    ASSERT_TRUE(std::getline(table, row));
    std::istringstream fields(row);
    double expected[5];
    char comma;
    fields >> expected[0];
    for (int i = 1; i < 5; ++i) fields >> comma >> expected[i];
    EXPECT_NEAR(static_cast<double>(can->stamp.ns()) * 1e-9, expected[0], 2e-6);
    bool same = true;
    for (size_t i = 0; i < 4; ++i) {
      same = same && std::abs(samples.wheels->wheel_speed[i] - expected[i + 1]) < 1e-6;
    }
    EXPECT_TRUE(same) << line;
    equal += same;
  }
  EXPECT_EQ(equal, 4974u);
  EXPECT_EQ(reader.frames(), 135468u);
  EXPECT_EQ(reader.problems().count(), 0u);
}

}  // namespace
}  // namespace infuse::vehicle
