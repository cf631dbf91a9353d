#include "drivers/velodyne/packet.hpp"

#include <gtest/gtest.h>

#include "tests/drivers/velodyne/oracle.hpp"

namespace infuse::velodyne {
namespace {

std::vector<uint8_t> make_packet(Model model, ReturnMode mode = ReturnMode::kStrongest) {
  return make_scene({.model = model,
                     .mode = mode,
                     .turns = 0.02,
                     .start_us = 123'456'789,
                     .calibration = built_in_calibration(model)})
      .packets[0]
      .payload;
}

TEST(Packet, ParsesHeaders) {
  const auto packet = parse_packet(model_info(Model::kVlp32c), make_packet(Model::kVlp32c));
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->counter_us, 123'456'789U);
  EXPECT_EQ(packet->mode, ReturnMode::kStrongest);
  EXPECT_EQ(packet->product_id, 0x28);
  EXPECT_EQ(packet->sequences, 12);
  EXPECT_EQ(packet->azimuth[0], 35'000);
  const auto dual =
      parse_packet(model_info(Model::kVls128), make_packet(Model::kVls128, ReturnMode::kDual));
  ASSERT_TRUE(dual);
  EXPECT_TRUE(dual->dual());
  EXPECT_EQ(dual->sequences, 1);
}

TEST(Packet, ReadsThreeHundredAndSixtyDegreesAsZero) {
  std::vector<uint8_t> bytes = make_packet(Model::kHdl32e);
  bytes[402] = 0xA0;
  bytes[403] = 0x8C;
  const auto packet = parse_packet(model_info(Model::kHdl32e), bytes);
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->azimuth[4], 0);
  bytes[402] = 0xA1;
  EXPECT_EQ(parse_packet(model_info(Model::kHdl32e), bytes)->azimuth[4], kNoAzimuth);
  for (size_t block = 5; block < 11; ++block) {
    bytes[block * 100 + 2] = 0xA1;
    bytes[block * 100 + 3] = 0x8C;
  }
  EXPECT_EQ(parse_packet(model_info(Model::kHdl32e), bytes).error(), PacketFault::kAzimuth);
}

TEST(Packet, RefusesAnotherLayout) {
  for (const ModelInfo& info : models()) {
    for (const ModelInfo& other : models()) {
      if (info.banks == other.banks) continue;
      EXPECT_EQ(parse_packet(other, make_packet(info.model)).error(), PacketFault::kFlag)
          << info.name << " read as " << other.name;
    }
  }
  EXPECT_EQ(parse_packet(model_info(Model::kHdl32e), {}).error(), PacketFault::kSize);
}

// An HDL-64E at rest repeats its azimuth too: that is not a second return.
TEST(Packet, RepeatedAzimuthMeansTwoReturnsOnlyIfTheSensorTurns) {
  const ModelInfo& s3 = model_info(Model::kHdl64eS3);
  std::vector<uint8_t> bytes = make_packet(Model::kHdl64eS3, ReturnMode::kDual);
  ASSERT_TRUE(parse_packet(s3, bytes));
  EXPECT_TRUE(parse_packet(s3, bytes)->dual());
  for (size_t block = 0; block < kBlocks; ++block) {
    bytes[block * 100 + 2] = 10;
    bytes[block * 100 + 3] = 0;
  }
  ASSERT_TRUE(parse_packet(s3, bytes));
  EXPECT_FALSE(parse_packet(s3, bytes)->dual());
  std::vector<uint8_t> vlp16 = make_packet(Model::kVlp16);
  vlp16[1204] = 0x39;
  EXPECT_EQ(parse_packet(model_info(Model::kVlp16), vlp16).error(), PacketFault::kDualPair);
}

TEST(Packet, CounterDifferenceSpansTheTopOfTheHour) {
  EXPECT_EQ(counter_difference_us(553, 3'600'000'000 - 10), 563);
  EXPECT_EQ(counter_difference_us(653, 3'600'000'100), 553);  // it had passed the hour
  EXPECT_EQ(counter_difference_us(3'599'999'000, 500), -1'500);
  EXPECT_EQ(counter_difference_us(700, 200), 500);
}

}  // namespace
}  // namespace infuse::velodyne
