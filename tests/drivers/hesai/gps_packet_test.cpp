#include "drivers/hesai/gps_packet.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string_view>
#include <vector>

namespace infuse::hesai {
namespace {

std::vector<uint8_t> gps_bytes(std::string_view sentence, bool locked) {
  std::vector<uint8_t> bytes(512, 0xDF);
  bytes[0] = 0xFF;
  bytes[1] = 0xEE;
  bytes[14] = 0x40;
  bytes[15] = 0xE2;
  bytes[16] = 0x01;
  bytes[17] = 0x00;
  std::fill(bytes.begin() + 18, bytes.begin() + 102, 0);
  std::copy(sentence.begin(), sentence.end(), bytes.begin() + 18);
  bytes[506] = 'A';
  bytes[507] = locked ? 1 : 0;
  return bytes;
}

TEST(HesaiGpsPacket, HasASentenceAndTheLock) {
  const auto packet = parse_gps_packet(
      gps_bytes("$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A\r\n", true));
  ASSERT_TRUE(packet);
  EXPECT_TRUE(packet->pps_locked);
  EXPECT_EQ(packet->microseconds, 123'456u);
  ASSERT_TRUE(packet->sentence);
  EXPECT_TRUE(packet->sentence->has_date);
  EXPECT_TRUE(packet->sentence->fix.valid);
}

TEST(HesaiGpsPacket, MayHaveNoSentence) {
  const auto packet = parse_gps_packet(gps_bytes("", false));
  ASSERT_TRUE(packet);
  EXPECT_FALSE(packet->pps_locked);
  EXPECT_EQ(packet->sentence.error(), gnss::NmeaFault::kNoSentence);
}

TEST(HesaiGpsPacket, IsOf512BytesAndHasItsMark) {
  auto bytes = gps_bytes("", false);
  bytes[1] = 0;
  EXPECT_FALSE(parse_gps_packet(bytes));
  bytes[1] = 0xEE;
  bytes.push_back(0);
  EXPECT_FALSE(parse_gps_packet(bytes));
  EXPECT_FALSE(parse_gps_packet({}));
}

}  // namespace
}  // namespace infuse::hesai
