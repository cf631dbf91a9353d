// A replay reads GNSS fixes from position packets, as a live run does.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/velodyne/velodyne_maker.hpp"
#include "fixtures/lidar/nmea_sentence.hpp"
#include "fixtures/scene/capture.hpp"
#include "fixtures/velodyne/position_encoder.hpp"
#include "tests/daemon/pipeline/run_replay.hpp"
#include "tests/real_data.hpp"

namespace infuse::daemon {
namespace {

/// Fixes that an intake returns for position packets with these sentences.
std::vector<GnssFix> fixes_of(const std::vector<std::string>& sentences, uint32_t sender = 7,
                              uint32_t expected_sender = 0) {
  LidarSetup setup;
  setup.decoder.model = &velodyne::lidar_model(velodyne::Model::kHdl32e);
  setup.decoder.sender = expected_sender;
  LidarIntake intake(setup);
  std::vector<GnssFix> fixes;
  for (size_t i = 0; i < sentences.size(); ++i) {
    const auto packet = velodyne::encode_position_packet({.sentence = sentences[i]});
    intake.add_datagram(
        {Stamp::from_ns(static_cast<int64_t>(i)), sender, 8308, 8308, packet}, [](Sweep&) {},
        [&](const GnssFix& fix) { fixes.push_back(fix); });
  }
  const LidarCounters& counters = intake.counters();
  const bool expected = expected_sender == 0 || sender == expected_sender;
  EXPECT_EQ(expected ? counters.position_packets : counters.wrong_sender, sentences.size());
  return fixes;
}

std::string sentence_at(int64_t second) {
  return fixtures::rmc_sentence(
      {.utc_ns = (1'600'000'000 + second) * 1'000'000'000, .latitude = 0.8, .longitude = 0.2});
}

TEST(PositionPackets, EverySentenceGivesOneFix) {
  const auto fixes = fixes_of({sentence_at(0), sentence_at(0), "", sentence_at(0), sentence_at(1)});
  ASSERT_EQ(fixes.size(), 2U);
  EXPECT_EQ(fixes[0].stamp, Stamp::from_ns(0));
  EXPECT_EQ(fixes[1].stamp, Stamp::from_ns(4));
  EXPECT_NEAR(fixes[1].latitude, 0.8, 1e-7);
  EXPECT_EQ(fixes[1].utc_ns, 1'600'000'001'000'000'000);
}

TEST(PositionPackets, UnexpectedSendersGiveNoFix) {
  EXPECT_EQ(fixes_of({sentence_at(0)}, 7, 7).size(), 1U);
  EXPECT_EQ(fixes_of({sentence_at(0)}, 8, 7).size(), 0U);
}

TEST(PositionPackets, ABareCaptureHasAGnssDevice) {
  const TemporaryFolder folder;
  const auto made = fixtures::make_capture(
      folder / "street.pcap",
      {.model = &velodyne::lidar_model(velodyne::Model::kVlp16), .duration = from_seconds(3)});
  ASSERT_TRUE(made);
  const auto result = run_replay(folder / "street.pcap");
  ASSERT_TRUE(result) << result.error().message();
  ASSERT_EQ(result->sensors.size(), 2U);
  EXPECT_EQ(result->sensors[1].id.kind, SensorKind::kGnss);
  EXPECT_EQ(result->sensors[1].device.endpoint, "position packets of lidar");
  EXPECT_GE(result->totals.counters.gnss.received, 1U);
  EXPECT_LE(result->totals.counters.gnss.received, made->position_packets);
}

TEST(PositionPackets, ARealCaptureHasFixes) {
  INFUSE_REAL_DATA_OR_SKIP(capture, "velodyne/hdl32e-moving.pcap");
  const auto result = run_replay(capture);
  ASSERT_TRUE(result) << result.error().message();
  ASSERT_EQ(result->sensors.size(), 2U);
  EXPECT_EQ(result->sensors.back().id.kind, SensorKind::kGnss);
  EXPECT_GT(result->totals.counters.gnss.received, 0U);
}

}  // namespace
}  // namespace infuse::daemon
