#include "drivers/velodyne/position_packet.hpp"
#include "drivers/measurement/angles.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "fixtures/lidar/nmea_sentence.hpp"
#include "fixtures/velodyne/position_encoder.hpp"

namespace infuse::velodyne {
namespace {

TEST(PositionPacket, ParsesCounterPpsAndSentence) {
  const std::string sentence = fixtures::gga_sentence({.talker = "GN", .latitude = 0.5});
  for (uint8_t pps = 0; pps < 4; ++pps) {
    const auto bytes =
        encode_position_packet({.counter_us = 0xD693A401, .pps = pps, .sentence = sentence});
    const auto packet = parse_position_packet(bytes);
    ASSERT_TRUE(packet);
    EXPECT_EQ(packet->counter_us, 0xD693A401U);
    EXPECT_EQ(static_cast<uint8_t>(packet->pps), pps);
    ASSERT_TRUE(packet->sentence);
    EXPECT_NEAR(packet->sentence->fix.latitude, 0.5, 1e-11);
  }
}

TEST(PositionPacket, ReadsInertialValuesAsSigned12Bits) {
  const auto bytes = encode_position_packet(
      {.sentence = "", .imu = {{{-2048, 0, 2047, -1}, {100, -100, 819, 0}, {0, 0, 0, 0}}}});
  const auto packet = parse_position_packet(bytes);
  ASSERT_TRUE(packet);
  EXPECT_NEAR(packet->imu[0].angular_velocity, -2048 * 0.09766 * kDegree, 1e-12);
  EXPECT_NEAR(packet->imu[0].temperature, 25, 1e-12);
  EXPECT_NEAR(packet->imu[0].linear_acceleration[0], 2047 * 0.001221 * 9.80665, 1e-9);
  EXPECT_NEAR(packet->imu[0].linear_acceleration[1], -0.001221 * 9.80665, 1e-9);
  EXPECT_NEAR(packet->imu[1].temperature, 25 - 14.53, 1e-9);
  EXPECT_NEAR(packet->imu[1].linear_acceleration[0], 9.80665, 0.01);
  ASSERT_FALSE(packet->sentence);
  EXPECT_EQ(packet->sentence.error(), gnss::NmeaFault::kNoSentence);
}

TEST(PositionPacket, RefusesOtherBytes) {
  auto bytes = encode_position_packet({.sentence = ""});
  EXPECT_FALSE(parse_position_packet(std::span(bytes).first(511)));
  EXPECT_FALSE(parse_position_packet({}));
  bytes[0xCA] = 4;
  EXPECT_FALSE(parse_position_packet(bytes));
}

}  // namespace
}  // namespace infuse::velodyne
