#include "drivers/ouster/imu_packet.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <vector>

#include "tests/drivers/ouster/made_packet.hpp"

namespace infuse::ouster {
namespace {

std::vector<uint8_t> made_imu_packet(float acceleration_x) {
  std::vector<uint8_t> bytes;
  for (const int64_t time : {11, 22, 33}) put<int64_t>(bytes, time);
  for (const float value : {acceleration_x, 0.5F, 1.0F, 10.0F, -20.0F, 30.0F}) put(bytes, value);
  return bytes;
}

TEST(OusterImuPacket, ReadsEveryField) {
  const auto packet = parse_imu_packet(made_imu_packet(0.25F));
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->diagnostic_ns, 11);
  EXPECT_EQ(packet->accelerometer_ns, 22);
  EXPECT_EQ(packet->gyro_ns, 33);
  EXPECT_EQ(packet->acceleration_g, (std::array{0.25F, 0.5F, 1.0F}));
  EXPECT_EQ(packet->rate_deg_per_s, (std::array{10.0F, -20.0F, 30.0F}));
}

TEST(OusterImuPacket, TurnsTheSampleIntoTheSensorsAxes) {
  Eigen::Isometry3d quarter_turn = Eigen::Isometry3d::Identity();
  quarter_turn.linear() << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const ImuSample sample =
      to_sample(*parse_imu_packet(made_imu_packet(0.25F)), quarter_turn, Stamp::from_ns(5));
  EXPECT_EQ(sample.stamp.ns(), 5);
  constexpr double kDegrees = std::numbers::pi / 180;
  EXPECT_DOUBLE_EQ(sample.angular_velocity[0], 20 * kDegrees);
  EXPECT_DOUBLE_EQ(sample.angular_velocity[1], 10 * kDegrees);
  EXPECT_DOUBLE_EQ(sample.angular_velocity[2], 30 * kDegrees);
  EXPECT_DOUBLE_EQ(sample.linear_acceleration[0], -0.5 * 9.80665);
  EXPECT_DOUBLE_EQ(sample.linear_acceleration[1], 0.25 * 9.80665);
  EXPECT_DOUBLE_EQ(sample.linear_acceleration[2], 9.80665);
}

TEST(OusterImuPacket, RefusesOtherBytes) {
  auto bytes = made_imu_packet(0);
  bytes.push_back(0);
  EXPECT_FALSE(parse_imu_packet(bytes));
  EXPECT_FALSE(parse_imu_packet({}));
  EXPECT_FALSE(parse_imu_packet(made_imu_packet(std::numeric_limits<float>::infinity())));
  EXPECT_FALSE(parse_imu_packet(made_imu_packet(std::numeric_limits<float>::quiet_NaN())));
}

}  // namespace
}  // namespace infuse::ouster
