#include "drivers/robosense/packet.hpp"

#include <gtest/gtest.h>

#include "drivers/lidar/azimuth.hpp"
#include "drivers/lidar/lidar_maker.hpp"
#include "drivers/robosense/info_packet.hpp"
#include "drivers/robosense/robosense_maker.hpp"
#include "tests/drivers/robosense/made_packet.hpp"

namespace infuse::robosense {
namespace {

std::vector<uint8_t> good_packet() {
  return make_data_packet(0x01020304, 1'483'724'884, 201'573,
                          {473, 492, 512, 532, 553, 573, 592, 612, 633, 653, 673, 36'000});
}

TEST(RobosensePacket, HoldsTimeNumberAndAzimuths) {
  auto bytes = good_packet();
  const auto packet = parse_packet(bytes);
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->number, 0x01020304u);
  EXPECT_EQ(packet->time_ns, 1'483'724'884'201'573'000);
  EXPECT_EQ(packet->distance_unit, 0.0025F);
  EXPECT_EQ(packet->azimuth[0], 473);
  EXPECT_EQ(packet->azimuth[11], 0);
  EXPECT_FALSE(packet->repeats_azimuths);
  EXPECT_FALSE(packet->stands);
  bytes[17] = 0;
  EXPECT_EQ(parse_packet(bytes)->distance_unit, 0.005F);
}

TEST(RobosensePacket, TwoReturnsRepeatAzimuthsAndAStandingSensorAllOfThem) {
  const auto pairs = parse_packet(
      make_data_packet(0, 1, 0, {40, 40, 60, 60, 80, 80, 100, 100, 120, 120, 140, 140}));
  EXPECT_TRUE(pairs->repeats_azimuths);
  EXPECT_FALSE(pairs->stands);
  const auto standing = parse_packet(make_data_packet(0, 1, 0, std::vector<uint16_t>(12, 9)));
  EXPECT_FALSE(standing->repeats_azimuths);
  EXPECT_TRUE(standing->stands);
}

TEST(RobosensePacket, OfABpearlHoldsADateOrSeconds) {
  const std::vector<uint16_t> azimuths(12, 7);
  auto older = make_bpearl_packet(3, 9, 1'483'724'884, 201'573, azimuths);
  const auto third = parse_packet(older);
  ASSERT_TRUE(third);
  EXPECT_EQ(third->time_ns, 1'483'724'884'201'573'000);
  EXPECT_EQ(third->number, 9u);
  EXPECT_EQ(third->distance_unit, 0.005F);
  const auto fourth = parse_packet(make_bpearl_packet(4, 0, 1'483'724'884, 201'573, azimuths));
  ASSERT_TRUE(fourth);
  EXPECT_EQ(fourth->time_ns, 1'483'724'884'201'573'000);
  EXPECT_EQ(fourth->number, std::nullopt);
  EXPECT_EQ(fourth->distance_unit, 0.0025F);
  put(older, 20, 0, 10);  // a clock that is not set: 2000-01-01
  EXPECT_EQ(parse_packet(older)->time_ns, 946'684'800'000'000'000);
  older[21] = 13;
  EXPECT_EQ(parse_packet(older).error(), PacketFault::kTime);
  older[21] = 2;
  older[23] = 25;
  EXPECT_EQ(parse_packet(older).error(), PacketFault::kTime);
}

PacketFault fault_of(std::vector<uint8_t> bytes, size_t at, std::vector<uint8_t> change) {
  std::copy(change.begin(), change.end(), bytes.begin() + static_cast<ptrdiff_t>(at));
  const auto packet = parse_packet(bytes);
  EXPECT_FALSE(packet) << at;
  return packet ? PacketFault::kSize : packet.error();
}

TEST(RobosensePacket, DamageIsNamed) {
  EXPECT_EQ(parse_packet(std::vector<uint8_t>(1'206)).error(), PacketFault::kSize);
  EXPECT_EQ(fault_of(good_packet(), 3, {0}), PacketFault::kHeader);
  EXPECT_EQ(fault_of(good_packet(), 42 + 700, {0xFF, 0xDD}), PacketFault::kFlag);
  EXPECT_EQ(fault_of(good_packet(), 26, {0, 0x0F, 0x42, 0x40}), PacketFault::kTime);
  EXPECT_EQ(fault_of(good_packet(), 20, {0, 1}), PacketFault::kTime);
  auto bytes = good_packet();
  for (size_t block = 0; block < 5; ++block) put(bytes, 44 + 100 * block, 36'001, 2);
  const auto packet = parse_packet(bytes);
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->azimuth[4], lidar::kNoAzimuth);
  EXPECT_EQ(packet->azimuth[5], 573);
  EXPECT_EQ(fault_of(bytes, 544, {0xFF, 0xFF}), PacketFault::kAzimuth);
}

TEST(RobosenseInfoPacket, HoldsAnglesModeAndClock) {
  const std::string rmc = "$GPRMC,222123,A,3639.2,N,12155.5,W,28.8,343.4,260112,013.8,E*";
  uint8_t sum = 0;
  for (size_t i = 1; i + 1 < rmc.size(); ++i) sum = static_cast<uint8_t>(sum ^ rmc[i]);
  char digits[5];
  std::snprintf(digits, sizeof digits, "%02X\r\n", sum);
  const auto packet =
      parse_info_packet(make_info_packet({1'494, -396, 0}, {-405, 361}, 6, rmc + digits));
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->motor_speed, 600);
  EXPECT_EQ(packet->mode, ReturnMode::kFirst);
  EXPECT_EQ(packet->time_mode, TimeMode::kGptp);
  EXPECT_TRUE(packet->synchronised);
  ASSERT_TRUE(packet->sentence);
  EXPECT_EQ(packet->sentence->fix.utc_ns, 1'327'616'483'000'000'000);
  EXPECT_EQ(packet->calibration.beams[0], (BeamAngles{1'494, -405}));
  EXPECT_EQ(packet->calibration.beams[1], (BeamAngles{-396, 361}));
  EXPECT_EQ(packet->calibration.beams[31], (BeamAngles{0, 0}));
}

TEST(RobosenseInfoPacket, NamesSoftwareUnitModeAndSourceOfTime) {
  auto bytes = make_info_packet({}, {}, 0);
  put(bytes, 50, 0x0020122202, 5);
  put(bytes, 292, 0x2410BAC9D50B, 6);
  EXPECT_EQ(maker().describe(bytes),
            "software 20122202, serial number 2410bac9d50b, two returns, time of gPTP");
  bytes[301] = 0;
  bytes[302] = 0;
  EXPECT_NE(maker().describe(bytes).find("time of GPS, which is not there"), std::string::npos);
}

TEST(RobosenseInfoPacket, WhatIsEmptyIsNotKnown) {
  auto bytes = make_info_packet({}, {}, 9);
  bytes[301] = 7;
  bytes[302] = 0;
  const auto packet = parse_info_packet(bytes);
  ASSERT_TRUE(packet);
  EXPECT_FALSE(packet->mode);
  EXPECT_FALSE(packet->time_mode);
  EXPECT_FALSE(packet->synchronised);
  EXPECT_FALSE(packet->sentence);
  EXPECT_TRUE(packet->calibration.invalid(model_info(Model::kHelios)));
  bytes[0] = 0;
  EXPECT_FALSE(parse_info_packet(bytes));
}

TEST(RobosenseCalibration, MustBeWithinTheFieldOfView) {
  for (const ModelInfo& info : models()) {
    Calibration calibration = built_in_calibration(info.model);
    EXPECT_FALSE(calibration.invalid(info)) << info.name;
    calibration.beams[3].azimuth_offset = info.max_azimuth_offset + 1;
    EXPECT_EQ(calibration.invalid(info), "azimuth of channel 4 is out of range");
    calibration.beams[3] = calibration.beams[2];
    EXPECT_EQ(calibration.invalid(info), "channel 4 has the direction of another");
    calibration.beams[1].elevation = -9'000;
    EXPECT_EQ(calibration.invalid(info), "elevation of channel 2 is out of range");
  }
}

}  // namespace
}  // namespace infuse::robosense
