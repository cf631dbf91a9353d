#include "drivers/velodyne/decoder.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "tests/drivers/lidar/assemble.hpp"
#include "tests/drivers/velodyne/model_scene.hpp"
#include "tests/drivers/velodyne/oracle.hpp"

namespace infuse::velodyne {
namespace {

TEST(Decoder, FullTurnsHaveNoGapsAndPartialTurnsReportThem) {
  const Scene scene = make_model_scene(Model::kHdl32e, {.start_azimuth = 90, .turns = 2.5});
  Decoder decoder({.model = &lidar_model(Model::kHdl32e)});
  const std::vector<Sweep> sweeps = assemble(decoder, scene.packets);
  ASSERT_EQ(sweeps.size(), 3U);  // 90° … 360°, a full turn, 0° … 270°
  EXPECT_TRUE(sweeps[1].gaps.empty());
  EXPECT_NEAR(to_seconds(sweeps[1].span), 0.1, 1e-4);
  EXPECT_EQ(sweeps[1].columns, 2170U);
  // 0 … 90° clockwise is 0 … −90° in the lidar frame.
  ASSERT_EQ(sweeps[0].gaps.size(), 1U);
  EXPECT_NEAR(sweeps[0].gaps[0].from, 0, 0.01);
  EXPECT_NEAR(sweeps[0].gaps[0].to, -std::numbers::pi / 2, 0.01);
  EXPECT_EQ(sweeps[1].clock.source, decoder.clock().source);
}

TEST(Decoder, CutsAtTheConfiguredAzimuthInsidePackets) {
  const Scene scene = make_model_scene(Model::kVlp16, {.start_azimuth = 0, .turns = 3});
  Decoder decoder({.model = &lidar_model(Model::kVlp16), .cut_azimuth = 123.45});
  const std::vector<Sweep> sweeps = assemble(decoder, scene.packets);
  ASSERT_EQ(sweeps.size(), 4U);
  for (size_t i = 1; i < 3; ++i) {
    const Sweep& sweep = sweeps[i];
    const double first = -std::atan2(sweep.y[0], sweep.x[0]) / kDegree;
    EXPECT_NEAR(first, 123.45, 0.45);  // within a block
    EXPECT_GE(first, 123.44);
    EXPECT_TRUE(sweep.gaps.empty());
    EXPECT_EQ(sweep.time_offset_ns[0] / 100'000, 0);
  }
}

TEST(Decoder, TheFirstSenderIsTheSensorIfNoneIsConfigured) {
  const Scene scene = make_model_scene(Model::kVlp16, {.turns = 0.2});
  Decoder decoder({.model = &lidar_model(Model::kVlp16)});
  Sweep sweep;
  for (const SentPacket& packet : scene.packets) {
    for (const uint32_t sender : {7U, 8U}) {
      Datagram datagram = packet.datagram();
      datagram.sender = sender;
      decoder.push(datagram);
      while (decoder.pull(sweep)) {
      }
    }
  }
  EXPECT_EQ(decoder.counters().packets, scene.packets.size());
  EXPECT_EQ(decoder.counters().wrong_sender, scene.packets.size());
}

TEST(Decoder, ASensorThatDoesNotTurnGivesSweepsOfBoundedLength) {
  const Scene scene = make_model_scene(Model::kHdl32e, {.turns_per_second = 0.001, .turns = 0.003});
  Decoder decoder({.model = &lidar_model(Model::kHdl32e)});
  const std::vector<Sweep> sweeps = assemble(decoder, scene.packets);
  ASSERT_GE(sweeps.size(), 7U);
  size_t expected = 0;
  for (const ExpectedSweep& sweep : scene.sweeps) expected += sweep.size();
  EXPECT_EQ(count_returns(sweeps), expected);
  for (const Sweep& sweep : sweeps) {
    EXPECT_LE(sweep.span, Duration(401'000'000));
    EXPECT_EQ(sweep.gaps.size(), 1U);
  }
}

// The rotation changes from 5 to 20 turns per second within two seconds.
TEST(Decoder, AChangeOfRotationChangesOnlyTheSpans) {
  const ModelInfo& info = model_info(Model::kHdl32e);
  PacketEncoder encoder({.model = Model::kHdl32e});
  const std::vector<fixtures::Echo> echoes(32, {10, 100});
  std::vector<SentPacket> packets;
  double azimuth = 0;
  for (size_t i = 0; i < 43'404; ++i) {
    const double t = static_cast<double>(i) * to_seconds(info.cycle);
    if (encoder.add_sequence(static_cast<uint16_t>(static_cast<int64_t>(azimuth * 100) % 36'000),
                             static_cast<uint32_t>(t * 1e6), echoes)) {
      packets.push_back({Stamp::from_ns(1'000'000'000'000) + from_seconds(t + 6e-4),
                         {encoder.packet().begin(), encoder.packet().end()}});
    }
    azimuth += (5 + 7.5 * t) * 360 * to_seconds(info.cycle);
  }
  Decoder decoder({.model = &lidar_model(Model::kHdl32e)});
  const std::vector<Sweep> sweeps = assemble(decoder, packets);
  EXPECT_EQ(decoder.counters().lost_network, 0U);
  ASSERT_EQ(sweeps.size(), 25U);  // 5·2 + 7.5·2²/2 turns
  for (size_t i = 1; i + 1 < sweeps.size(); ++i) {
    EXPECT_LT(sweeps[i].span, sweeps[i - 1].span);
    EXPECT_TRUE(sweeps[i].gaps.empty());
  }
  EXPECT_EQ(count_returns(sweeps), packets.size() * 384);
}

// A sensor configured to scan 100° … 300°. The jump may be anywhere inside packets.
TEST(Decoder, APartialTurnIsOneSweepWithExactTimes) {
  const ModelInfo& info = model_info(Model::kVlp32c);
  PacketEncoder encoder({.model = Model::kVlp32c});
  const std::vector<fixtures::Echo> echoes(32, {10, 100});
  std::vector<SentPacket> packets;
  std::vector<int64_t> firings_ns;  // of all sequences sent
  std::vector<bool> begins;
  bool was_in = true;
  for (size_t i = 0; i < 40'000; ++i) {
    const int64_t t_ns = static_cast<int64_t>(i) * info.cycle.count();
    const int64_t azimuth = (10'000 + t_ns * 360'000 / 1'000'000'000) % 36'000;
    const bool in = azimuth >= 10'000 && azimuth < 30'000;
    if (in) {
      firings_ns.push_back(t_ns);
      begins.push_back(!was_in);
      if (encoder.add_sequence(static_cast<uint16_t>(azimuth), static_cast<uint32_t>(t_ns / 1000),
                               echoes)) {
        packets.push_back({Stamp::from_ns(1'000'000'000'000 + t_ns + 60'000),
                           {encoder.packet().begin(), encoder.packet().end()}});
      }
    }
    was_in = in;
  }
  Decoder decoder({.model = &lidar_model(Model::kVlp32c), .cut_azimuth = 0});
  const std::vector<Sweep> sweeps = assemble(decoder, packets);
  ASSERT_GE(sweeps.size(), 21U);
  size_t firing = 0;
  size_t sweeps_seen = 0;
  for (const Sweep& sweep : sweeps) {
    EXPECT_TRUE(sweeps_seen == 0 || begins[firing]) << sweeps_seen;
    const int64_t start_ns = firings_ns[firing];
    for (size_t i = 0; i < sweep.size(); i += 32) {
      const int64_t expected = firings_ns[firing + sweep.column[i]] - start_ns;
      ASSERT_NEAR(sweep.time_offset_ns[i], static_cast<double>(expected), 2'100)
          << "sweep " << sweeps_seen << " column " << sweep.column[i];
    }
    firing += sweep.columns;
    ++sweeps_seen;
  }
  // A jump between two packets looks like loss until the first jump inside one.
  EXPECT_LE(decoder.counters().lost_network, 70U);
}

}  // namespace
}  // namespace infuse::velodyne
