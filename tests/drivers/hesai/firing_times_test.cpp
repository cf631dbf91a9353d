#include "drivers/hesai/firing_times.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace infuse::hesai {
namespace {

/// A Pandar64 fires pairs of channels (from 1): the first sixteen pairs 1.304 us apart, the others
/// 1.968 us, the first 3.62 us before the block's end (manual, "Laser Firing Time").
constexpr int kPandar64Pairs[32][2]{
    {51, 61}, {45, 60}, {39, 57}, {9, 55},  {49, 63}, {43, 59}, {7, 56},  {53, 64},
    {47, 62}, {41, 58}, {6, 54},  {5, 48},  {4, 50},  {3, 52},  {2, 46},  {1, 44},
    {24, 33}, {27, 42}, {21, 36}, {15, 30}, {22, 37}, {16, 31}, {10, 25}, {19, 34},
    {13, 28}, {20, 35}, {14, 29}, {8, 23},  {17, 32}, {11, 26}, {18, 38}, {12, 40}};

/// Order in which a Pandar40P's channels (from 1) fire, backwards from its block's end, and their
/// time before it in us (manual, table II.4).
constexpr struct {
  int channel;
  double before_us;
} kPandar40pOrder[]{{4, 3.62},   {40, 3.62},  {36, 4.92},  {28, 6.23},  {12, 8.19},  {16, 8.19},
                    {32, 9.5},   {24, 11.47}, {29, 12.77}, {17, 14.74}, {3, 16.04},  {39, 16.04},
                    {35, 17.35}, {25, 18.65}, {9, 20.62},  {13, 20.62}, {31, 21.92}, {21, 23.89},
                    {26, 25.19}, {14, 27.16}, {2, 28.47},  {38, 28.47}, {34, 29.77}, {6, 31.74},
                    {22, 31.74}, {10, 33.71}, {30, 35.01}, {18, 36.98}, {23, 38.95}, {11, 40.91},
                    {1, 42.22},  {37, 42.22}, {33, 43.52}, {5, 45.49},  {19, 45.49}, {7, 47.46},
                    {27, 48.76}, {15, 50.73}, {20, 52.7},  {8, 54.67}};

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

TEST(HesaiFiringTimes, OfAQt128AlternateBetweenTwoSequences) {
  const FiringTimes first = firing_times(Model::kQt128, 0);
  const FiringTimes second = firing_times(Model::kQt128, 1);
  // Some rows of the unit's firing time file.
  EXPECT_EQ(first.channel_ns[32], 27'656);
  EXPECT_EQ(first.channel_ns[63], 49'832);
  EXPECT_EQ(first.channel_ns[64], 1'456);
  EXPECT_EQ(first.channel_ns[95], 23'632);
  EXPECT_EQ(first.channel_ns[98], 600);
  EXPECT_EQ(first.channel_ns[127], 48'120);
  EXPECT_EQ(second.channel_ns[0], 2'312);
  EXPECT_EQ(second.channel_ns[31], 24'488);
  EXPECT_EQ(second.channel_ns[64], 600);
  EXPECT_EQ(second.channel_ns[95], 22'776);
  EXPECT_EQ(second.channel_ns[96], 26'800);
  EXPECT_EQ(second.channel_ns[127], 48'976);
  for (const auto& [times, silent] : {std::pair(first, 0), std::pair(second, 32)}) {
    std::multiset<int> fired;
    for (int channel = 0; channel < 128; ++channel) {
      const int ns = times.channel_ns[static_cast<size_t>(channel)];
      if (channel < silent || channel >= silent + 32) fired.insert(ns);
    }
    EXPECT_EQ(std::set<int>(fired.begin(), fired.end()).size(), 96u);
    EXPECT_EQ(*fired.begin(), 600);
    EXPECT_EQ(*fired.rbegin(), 100'520);
    EXPECT_EQ(times.first_ns, 600);
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
