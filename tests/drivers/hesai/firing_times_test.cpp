#include "drivers/hesai/firing_times.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/drivers/hesai/manual_times.hpp"

namespace infuse::hesai {
namespace {

TEST(HesaiFiringTimes, OfAPandar64AreTheManuals) {
  const FiringTimes times = firing_times(Model::kPandar64, 0);
  for (int pair = 0; pair < 32; ++pair) {
    const int ns = -3'620 - 1'304 * std::min(pair, 15) - 1'968 * std::max(pair - 15, 0);
    for (const int channel : kPandar64Pairs[pair]) {
      EXPECT_EQ(times.channel_ns[static_cast<size_t>(channel - 1)], ns) << channel;
    }
  }
  EXPECT_EQ(times.first_ns, -54'668);
  EXPECT_EQ(times.last_ns, -3'620);
}

TEST(HesaiFiringTimes, OfAPandar40pAreTheManuals) {
  const FiringTimes times = firing_times(Model::kPandar40p, 0);
  std::set<int> channels;
  for (const auto& [channel, before_us] : kPandar40pOrder) {
    channels.insert(channel);
    EXPECT_EQ(times.channel_ns[static_cast<size_t>(channel - 1)], -std::lround(before_us * 1000));
  }
  EXPECT_EQ(channels.size(), 40u);
}

TEST(HesaiFiringTimes, OfAQt64HaveLongerStepsAfterEachEighthChannel) {
  const FiringTimes times = firing_times(Model::kQt64, 0);
  EXPECT_EQ(times.first_ns, 12'310);
  EXPECT_EQ(times.last_ns, 146'450);
  for (size_t channel = 1; channel < 64; ++channel) {
    const int step = times.channel_ns[channel] - times.channel_ns[channel - 1];
    const int expected = channel % 16 == 0 ? 3'045 : channel % 8 == 0 ? 2'450 : 2'060;
    EXPECT_NEAR(step, expected, 11) << channel;
  }
}

TEST(HesaiFiringTimes, AreThoseOfTheLists) {
  for (const ModelInfo& info : models()) {
    for (size_t loop = 0; loop < number_of_loops(info.model); ++loop) {
      const FiringTimes times = firing_times(info.model, loop);
      int32_t first = 1'000'000;
      int32_t last = -1'000'000;
      for (int channel = 0; channel < info.lasers; ++channel) {
        const auto us = manual_channel_us(info.model, channel, static_cast<int>(loop));
        if (!us) continue;
        const auto ns = static_cast<int32_t>(std::lround(*us * 1000));
        EXPECT_EQ(times.channel_ns[static_cast<size_t>(channel)], ns) << info.name << channel;
        first = std::min(first, ns);
        last = std::max(last, ns);
      }
      EXPECT_EQ(times.first_ns, first) << info.name;
      EXPECT_EQ(times.last_ns, last) << info.name;
      EXPECT_EQ(times.azimuth_ns, std::lround(manual_azimuth_us(info.model) * 1000)) << info.name;
    }
  }
}

TEST(HesaiFiringTimes, OfAQt128sTwoSequencesLeaveOutABankEach) {
  for (const size_t loop : {size_t{0}, size_t{1}}) {
    const FiringTimes times = firing_times(Model::kQt128, loop);
    for (size_t channel = 32 * loop; channel < 32 * loop + 32; ++channel) {
      EXPECT_EQ(times.channel_ns[channel], 600);
    }
  }
}

TEST(HesaiFiringTimes, OfAnXtAreEven) {
  EXPECT_EQ(firing_times(Model::kXt32, 0).channel_ns[31], 368 + 31 * 1'512);
  EXPECT_EQ(firing_times(Model::kXt16, 0).channel_ns[15], 368 + 15 * 3'024);
  EXPECT_EQ(firing_times(Model::kXt32m, 0).channel_ns[15], 368 + 15 * 2'888);
  EXPECT_EQ(firing_times(Model::kXt32m, 0).channel_ns[16], 368);
}

TEST(HesaiFiringTimes, OfBlocksEndAtThePacketsTime) {
  Packet packet;
  packet.sequences = 8;
  EXPECT_EQ(block_time_ns(Model::kXt32, packet, 7), 5'632);
  EXPECT_EQ(block_time_ns(Model::kXt32, packet, 0), 5'632 - 7 * 50'000);
  packet.sequences = 5;
  EXPECT_EQ(block_time_ns(Model::kPandar40p, packet, 4), -28'580);
  EXPECT_EQ(block_time_ns(Model::kPandar40p, packet, 0), -28'580 - 4 * 55'560);
  packet.sequences = 3;
  EXPECT_EQ(block_time_ns(Model::kPandar64, packet, 0), -42'580 - 2 * 55'560);
  packet.sequences = 4;
  EXPECT_EQ(block_time_ns(Model::kQt64, packet, 0), 25'710);
  EXPECT_EQ(block_time_ns(Model::kQt64, packet, 3), 25'710 + 500'000);
  packet.sequences = 2;
  EXPECT_EQ(block_time_ns(Model::kQt128, packet, 0), 9'000 - 111'110);
  EXPECT_EQ(block_time_ns(Model::kQt128, packet, 1), 9'000);
}

}  // namespace
}  // namespace infuse::hesai
