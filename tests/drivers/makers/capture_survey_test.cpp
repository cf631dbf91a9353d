#include "drivers/makers/capture_survey.hpp"

#include <gtest/gtest.h>

#include <array>

#include "drivers/velodyne/packet.hpp"
#include "drivers/velodyne/position_packet.hpp"
#include "fixtures/lidar/nmea_sentence.hpp"
#include "fixtures/velodyne/position_encoder.hpp"

namespace infuse::makers {
namespace {

/// A data packet of a Velodyne without returns.
std::vector<uint8_t> flagged_packet() {
  std::vector<uint8_t> bytes(velodyne::kPacketSize);
  for (size_t block = 0; block < velodyne::kBlocks; ++block) {
    bytes[100 * block] = 0xFF;
    bytes[100 * block + 1] = 0xEE;
  }
  return bytes;
}

Stamp at_ms(int64_t ms) { return Stamp::from_ns(ms * 1'000'000); }

TEST(Arrivals, MeasureRateGapsAndBackwardStamps) {
  Arrivals arrivals;
  EXPECT_EQ(arrivals.rate_hz(), 0);
  for (const int64_t ms : {0, 100, 200, 150, 500}) arrivals.add(at_ms(ms));
  EXPECT_EQ(arrivals.count, 5U);
  EXPECT_EQ(arrivals.backward, 1U);
  EXPECT_EQ(arrivals.longest_gap, from_seconds(0.3));
  EXPECT_EQ(arrivals.longest_gap_at, at_ms(200));
  EXPECT_EQ(arrivals.span(), from_seconds(0.5));
  EXPECT_DOUBLE_EQ(arrivals.rate_hz(), 8);
}

TEST(CaptureSurvey, SortsDatagramsBySenderPortAndKind) {
  const std::vector<uint8_t> data = flagged_packet(), other(100);
  CaptureSurvey survey;
  survey.add({at_ms(0), 1, 2368, 2368, data});
  survey.add({at_ms(1), 2, 2368, 2368, data});
  survey.add({at_ms(2), 1, 2368, 2368, other});
  survey.add({at_ms(3), 1, 2368, 2368, data});
  // Its size is not enough for a packet of a lidar.
  const std::vector<uint8_t> noise(velodyne::kPacketSize, 0x5A);
  survey.add({at_ms(4), 3, 2368, 2368, noise});
  ASSERT_EQ(survey.streams().size(), 4U);
  EXPECT_EQ(survey.streams()[3].packet_class, lidar::PacketClass::kOther);
  EXPECT_EQ(survey.streams()[0].arrivals.count, 2U);
  EXPECT_EQ(survey.streams()[0].packet_class, lidar::PacketClass::kData);
  EXPECT_EQ(survey.streams()[1].sender, 2U);
  EXPECT_EQ(survey.streams()[2].packet_class, lidar::PacketClass::kOther);
  EXPECT_EQ(survey.streams()[2].bytes, 100U);
}

TEST(CaptureSurvey, CountsPositionPacketsWithNmeaSentences) {
  const std::string sentence = fixtures::rmc_sentence({.utc_ns = 1'600'000'000'000'000'000});
  const auto with = velodyne::encode_position_packet({.counter_us = 1, .sentence = sentence});
  const auto without = velodyne::encode_position_packet({.counter_us = 2, .sentence = ""});
  CaptureSurvey survey;
  for (const auto* packet : {&with, &without, &with}) {
    survey.add({at_ms(0), 1, 8308, 8308, *packet});
  }
  ASSERT_EQ(survey.streams().size(), 1U);
  EXPECT_EQ(survey.streams()[0].packet_class, lidar::PacketClass::kInformation);
  EXPECT_EQ(survey.streams()[0].arrivals.count, 3U);
  EXPECT_EQ(survey.streams()[0].fixes, 2U);
}

TEST(CaptureSurvey, LimitsTheNumberOfStreams) {
  const std::vector<uint8_t> payload(10);
  CaptureSurvey survey;
  for (uint32_t sender = 0; sender < CaptureSurvey::kMaxStreams + 5; ++sender) {
    survey.add({at_ms(0), sender, 1, 1, payload});
  }
  EXPECT_EQ(survey.streams().size(), CaptureSurvey::kMaxStreams);
  EXPECT_EQ(survey.excess_datagrams(), 5U);
}

TEST(Address, IsParsedAndFormatted) {
  EXPECT_EQ(address_text(0x0A000007), "10.0.0.7");
  EXPECT_EQ(parse_address("10.0.0.7"), 0x0A000007U);
  for (const char* text : {"", "10.0.0", "10.0.0.256", "host", "10.0.0.7 "}) {
    EXPECT_EQ(parse_address(text), std::nullopt) << text;
  }
}

}  // namespace
}  // namespace infuse::makers
