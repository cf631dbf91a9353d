#include "drivers/makers/makers.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "drivers/makers/capture_survey.hpp"
#include "drivers/velodyne/packet.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"
#include "tests/drivers/makers/made_up_packet.hpp"

namespace infuse::makers {
namespace {

constexpr Stamp kStart = Stamp::from_ns(1'700'000'000'000'000'000);

std::vector<uint8_t> velodyne_packet() {
  return velodyne::maker().example_packet(velodyne::lidar_model(velodyne::Model::kVlp16), 0, 10);
}

/// Every sweep of these packets; `received`: indices in the order of arrival.
std::vector<Sweep> decode(lidar::LidarDecoder& decoder, const std::vector<uint32_t>& received) {
  std::vector<Sweep> sweeps;
  Sweep sweep;
  const auto pull = [&] {
    while (decoder.pull(sweep)) sweeps.push_back(std::exchange(sweep, Sweep()));
  };
  Stamp host = kStart;
  for (const uint32_t index : received) {
    const auto payload = made_up::packet(index, kStart, 10);
    const Stamp sent = kStart + (index + 1) * made_up::kSequences * made_up::kPeriod;
    host = std::max(host + Duration(1000), sent + Duration(50'000));
    decoder.push({host, 1, 7777, 7777, payload});
    pull();
  }
  decoder.finish();
  pull();
  return sweeps;
}

std::vector<uint32_t> count_to(uint32_t end) {
  std::vector<uint32_t> indices(end);
  std::iota(indices.begin(), indices.end(), 0U);
  return indices;
}

TEST(Makers, TheListKnowsVelodyne) {
  EXPECT_EQ(find_model("vlp16"), &velodyne::lidar_model(velodyne::Model::kVlp16));
  EXPECT_EQ(find_model("ringer4"), nullptr);
  const auto wrong = require_model("ringer4", "--model");
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().message(), testing::HasSubstr("VLS-128"));
  EXPECT_EQ(classify(velodyne_packet()).maker, &velodyne::maker());
  EXPECT_EQ(classify(std::vector<uint8_t>(7)).maker, nullptr);
}

TEST(MadeUpMaker, GivesSweepsOfItsTurns) {
  const auto decoder = lidar::make_decoder({.model = &made_up::model()}).value();
  const std::vector<Sweep> sweeps = decode(*decoder, count_to(375));  // three turns
  ASSERT_EQ(sweeps.size(), 3U);
  for (size_t i = 0; i < 3; ++i) {
    const Sweep& sweep = sweeps[i];
    EXPECT_EQ(sweep.columns, 1000U);
    ASSERT_EQ(sweep.size(), 4000U);
    EXPECT_EQ(sweep.rings, 4U);
    EXPECT_TRUE(sweep.gaps.empty());
    EXPECT_EQ(sweep.lost_packets, 0U);
    EXPECT_NEAR(to_seconds(sweep.stamp - kStart), 0.1 * static_cast<double>(i), 1e-4);
    for (size_t k = 0; k < sweep.size(); ++k) {
      ASSERT_NEAR(std::hypot(sweep.x[k], sweep.y[k]), 10, 0.01);
      const double azimuth = static_cast<double>(sweep.column[k]) * 36 * lidar::kCentidegree;
      ASSERT_NEAR(std::remainder(std::atan2(sweep.y[k], sweep.x[k]) + azimuth, 2 * M_PI), 0, 1e-5);
      ASSERT_EQ(sweep.time_offset_ns[k], sweep.column[k] * made_up::kPeriod.count());
    }
  }
  EXPECT_EQ(decoder->clock().source, ClockState::Source::kUtc);
  EXPECT_NEAR(decoder->counters().turns_hz, 10, 0.01);
  EXPECT_FALSE(decoder->counters().two_sensors);
  EXPECT_EQ(decoder->counters().wrong_model, 0U);
}

TEST(MadeUpMaker, LossesAndOrderAreThoseOfAllMakers) {
  std::vector<uint32_t> received = count_to(375);
  received.erase(received.begin() + 200, received.begin() + 207);
  std::swap(received[50], received[51]);
  received.insert(received.begin() + 80, received[79]);
  const auto decoder = lidar::make_decoder({.model = &made_up::model()}).value();
  const std::vector<Sweep> sweeps = decode(*decoder, received);
  ASSERT_EQ(sweeps.size(), 3U);
  EXPECT_EQ(sweeps[1].lost_packets, 7U);
  EXPECT_EQ(sweeps[1].gaps.size(), 1U);
  EXPECT_EQ(sweeps[0].size(), 4000U);
  const lidar::PacketCounters& counters = decoder->counters();
  EXPECT_EQ(counters.lost_network, 7U);
  EXPECT_EQ(counters.out_of_order, 1U);
  EXPECT_EQ(counters.duplicates, 1U);
}

/// Packets that are missing where the time jumps too are known by their numbers only.
TEST(MadeUpMaker, NumbersOfPacketsTellLossesExactly) {
  const auto decoder = lidar::make_decoder({.model = &made_up::model()}).value();
  Sweep sweep;
  for (const uint32_t number : {0U, 1U, 4U, 5U}) {
    auto payload = made_up::packet(number, kStart, 10);
    payload[4] = static_cast<uint8_t>(number < 2 ? number : number + 100);  // the time says two
    decoder->push({kStart + Duration(1'000'000) * number, 1, 7777, 7777, payload});
    while (decoder->pull(sweep)) {
    }
  }
  decoder->finish();
  while (decoder->pull(sweep)) {
  }
  EXPECT_EQ(decoder->counters().lost_network, 102U);
}

TEST(MadeUpMaker, AnImpossibleTimeIsMalformed) {
  const auto decoder = lidar::make_decoder({.model = &made_up::model()}).value();
  for (const uint8_t top : {uint8_t{0x80}, uint8_t{0x7F}}) {
    auto payload = made_up::packet(0, kStart, 10);
    payload[15] = top;
    decoder->push({kStart, 1, 7777, 7777, payload});
  }
  EXPECT_EQ(decoder->counters().malformed, 2U);
  EXPECT_STREQ(decoder->counters().malformed_reason, "an impossible device time");
  EXPECT_EQ(decoder->counters().packets, 0U);
}

/// Two turns of each maker's example give sweeps of its range.
TEST(Makers, AnExampleIsDecodedToItsRange) {
  size_t makers_with_one = 0;
  for (const lidar::LidarMaker* maker : all()) {
    for (const lidar::LidarModel& model : maker->models()) {
      if (maker->example_packet(model, 0, 20).empty()) continue;
      ++makers_with_one;
      const auto decoder = lidar::make_decoder({.model = &model}).value();
      Sweep sweep;
      size_t right = 0;
      for (uint32_t i = 0; i * maker->example_period(model) < from_seconds(0.25); ++i) {
        const auto payload = maker->example_packet(model, i, 20);
        decoder->push({kStart + (i + 1) * maker->example_period(model), 1, 1, 1, payload});
        while (decoder->pull(sweep)) {
          const auto of_range = std::ranges::count_if(
              sweep.range, [](float range) { return std::abs(range - 20) < 0.01; });
          right += static_cast<size_t>(of_range) == sweep.size() && sweep.gaps.empty();
        }
      }
      EXPECT_GE(right, 1U) << model.name;
      EXPECT_EQ(decoder->counters().malformed + decoder->counters().lost_network, 0U) << model.name;
    }
  }
  EXPECT_GE(makers_with_one, 7U);
}

// The list is the program's: this test comes last.
TEST(Makers, ACaptureMayHoldSeveralMakersAndNoise) {
  add(made_up::maker());
  EXPECT_EQ(find_model("ringer4"), &made_up::model());
  CaptureSurvey survey;
  const std::vector<uint8_t> velodyne = velodyne_packet(), noise(33);
  for (uint32_t i = 0; i < 20; ++i) {
    const Stamp stamp = kStart + Duration(1'000'000) * i;
    const auto payload = made_up::packet(i, kStart, 10);
    survey.add({stamp, 1, 7777, 7777, payload});
    survey.add({stamp, 2, 2368, 2368, velodyne});
    survey.add({stamp, 1, 7777, 7777, noise});
  }
  ASSERT_EQ(survey.streams().size(), 3U);
  EXPECT_EQ(survey.streams()[0].maker, &made_up::maker());
  EXPECT_EQ(survey.streams()[0].inference->infer()->model, &made_up::model());
  EXPECT_EQ(survey.streams()[1].maker, &velodyne::maker());
  EXPECT_EQ(survey.streams()[2].maker, nullptr);
  EXPECT_EQ(survey.streams()[2].inference, nullptr);
}

}  // namespace
}  // namespace infuse::makers
