#include "drivers/velodyne/decoder.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <stdexcept>

#include "fixtures/lidar/little_endian.hpp"
#include "tests/drivers/lidar/assemble.hpp"
#include "tests/drivers/velodyne/oracle.hpp"
#include "tests/drivers/velodyne/share.hpp"

namespace infuse::velodyne {
namespace {

Scene make_model_scene(Model model, SceneOptions options = {}) {
  options.model = model;
  options.calibration = built_in_calibration(model);
  return make_scene(options);
}

size_t count_returns(const std::vector<Sweep>& sweeps) {
  size_t sum = 0;
  for (const Sweep& sweep : sweeps) sum += sweep.size();
  return sum;
}

bool same_returns(const Sweep& a, const Sweep& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z && a.range == b.range && a.ring == b.ring &&
         a.column == b.column && a.time_offset_ns == b.time_offset_ns &&
         a.return_kind == b.return_kind && a.reflectivity == b.reflectivity;
}

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

TEST(Decoder, LostPacketsAreCountedAndLeaveAGap) {
  Scene scene = make_model_scene(Model::kHdl32e, {.start_azimuth = 0, .turns = 3});
  const size_t whole = scene.packets.size();
  // The second turn is packets 181 … 361; remove ten from its middle.
  scene.packets.erase(scene.packets.begin() + 250, scene.packets.begin() + 260);
  Decoder decoder({.model = &lidar_model(Model::kHdl32e)});
  const std::vector<Sweep> sweeps = assemble(decoder, scene.packets);
  EXPECT_EQ(decoder.counters().lost_network, 10U);
  EXPECT_EQ(decoder.counters().outages, 0U);
  EXPECT_EQ(decoder.counters().packets, whole - 10);
  ASSERT_EQ(sweeps.size(), 3U);
  EXPECT_EQ(sweeps[0].lost_packets, 0U);
  EXPECT_EQ(sweeps[1].lost_packets, 10U);
  ASSERT_EQ(sweeps[1].gaps.size(), 1U);
  double width = sweeps[1].gaps[0].from - sweeps[1].gaps[0].to;
  if (width < 0) width += 2 * std::numbers::pi;
  EXPECT_NEAR(width, 120 * 0.16589 * kDegree, 0.01);
  EXPECT_EQ(sweeps[2].lost_packets, 0U);
  EXPECT_NEAR(to_seconds(sweeps[1].span), 0.1, 1e-4);  // times continue over the gap
}

TEST(Decoder, LossOfMoreThanATurnEndsTheSweep) {
  Scene scene = make_model_scene(Model::kHdl32e, {.start_azimuth = 0, .turns = 4});
  scene.packets.erase(scene.packets.begin() + 100, scene.packets.begin() + 400);
  Decoder decoder({.model = &lidar_model(Model::kHdl32e)});
  const std::vector<Sweep> sweeps = assemble(decoder, scene.packets);
  EXPECT_EQ(decoder.counters().lost_network, 300U);
  EXPECT_EQ(decoder.counters().outages, 1U);
  EXPECT_EQ(decoder.counters().lost_in_outages, 300U);
  EXPECT_EQ(sweeps[0].lost_packets, 300U);
  for (const Sweep& sweep : sweeps) {
    EXPECT_LE(sweep.span, Duration(101'000'000));
    EXPECT_TRUE(std::is_sorted(sweep.column.begin(), sweep.column.end()));
  }
}

TEST(Decoder, DuplicateAndReorderedPacketsGiveTheSameSweeps) {
  const Scene scene = make_model_scene(Model::kVlp32c, {.turns = 2});
  Decoder deskewed({.model = &lidar_model(Model::kVlp32c)});
  const std::vector<Sweep> expected = assemble(deskewed, scene.packets);

  std::vector<SentPacket> disturbed;
  for (size_t i = 0; i < scene.packets.size(); ++i) {
    disturbed.push_back(scene.packets[i]);
    if (i % 7 == 0) disturbed.push_back(scene.packets[i]);       // duplicate, directly
    if (i % 11 == 5) disturbed.push_back(scene.packets[i - 3]);  // duplicate, later
    if (i % 13 == 6) {                                           // swap the next two
      disturbed.push_back(scene.packets[i + 2]);
      disturbed.push_back(scene.packets[i + 1]);
      i += 2;
    }
    if (i + 3 >= scene.packets.size()) {
      for (++i; i < scene.packets.size(); ++i) disturbed.push_back(scene.packets[i]);
    }
  }
  Decoder decoder({.model = &lidar_model(Model::kVlp32c)});
  const std::vector<Sweep> sweeps = assemble(decoder, disturbed);
  const lidar::PacketCounters& counters = decoder.counters();
  EXPECT_EQ(counters.packets, scene.packets.size());
  EXPECT_EQ(counters.lost_network, 0U);
  EXPECT_GT(counters.out_of_order, 10U);
  EXPECT_GT(counters.duplicates, 40U);
  EXPECT_EQ(counters.packets + counters.duplicates, disturbed.size());
  ASSERT_EQ(sweeps.size(), expected.size());
  for (size_t i = 0; i < sweeps.size(); ++i) {
    const Sweep& sweep = sweeps[i];
    ASSERT_EQ(sweep.range, expected[i].range);
    EXPECT_EQ(sweep.ring, expected[i].ring);
    EXPECT_EQ(sweep.column, expected[i].column);
    EXPECT_EQ(sweep.time_offset_ns, expected[i].time_offset_ns);
    EXPECT_EQ(sweep.reflectivity, expected[i].reflectivity);
    for (size_t k = 0; k < sweep.size(); ++k) {
      // A packet that arrived before its predecessor did not have its last step.
      ASSERT_NEAR(sweep.x[k], expected[i].x[k], 2e-4 * sweep.range[k]);
      ASSERT_NEAR(sweep.y[k], expected[i].y[k], 2e-4 * sweep.range[k]);
    }
  }
}

TEST(Decoder, IgnoresAVeryLatePacket) {
  Scene scene = make_model_scene(Model::kVlp32c, {.turns = 1});
  std::rotate(scene.packets.begin() + 20, scene.packets.begin() + 21, scene.packets.begin() + 41);
  Decoder decoder({.model = &lidar_model(Model::kVlp32c)});
  assemble(decoder, scene.packets);
  EXPECT_EQ(decoder.counters().too_late, 1U);
  EXPECT_EQ(decoder.counters().lost_network, 1U);
  EXPECT_EQ(decoder.counters().clock_jumps, 0U);
}

TEST(Decoder, CountsEveryRefusalByItsCause) {
  Scene scene = make_model_scene(Model::kVlp16, {.turns = 0.2});
  Decoder decoder({.model = &lidar_model(Model::kVlp16), .sender = 0x0A000007});
  const auto push = [&](std::vector<uint8_t> payload, uint32_t sender) {
    decoder.push({Stamp(), sender, 2368, 2368, payload});
    return std::string(decoder.counters().malformed_reason);
  };
  const std::vector<uint8_t> good = scene.packets[0].payload;
  push(good, 0x0A000008);
  EXPECT_EQ(push({good.begin(), good.end() - 1}, 0x0A000007), describe(PacketFault::kSize));
  std::vector<uint8_t> flag = good;
  flag[300] = 0;
  EXPECT_EQ(push(flag, 0x0A000007), describe(PacketFault::kFlag));
  std::vector<uint8_t> azimuth = good;
  for (size_t block = 0; block < 7; ++block) {
    azimuth[block * 100 + 2] = 0xA1;  // 36001
    azimuth[block * 100 + 3] = 0x8C;
  }
  EXPECT_EQ(push(azimuth, 0x0A000007), describe(PacketFault::kAzimuth));
  std::vector<uint8_t> pair = good;
  pair[1204] = 0x39;
  EXPECT_EQ(push(pair, 0x0A000007), describe(PacketFault::kDualPair));
  const lidar::PacketCounters& counters = decoder.counters();
  EXPECT_EQ(counters.wrong_sender, 1U);
  EXPECT_EQ(counters.malformed, 4U);
  EXPECT_EQ(counters.packets, 0U);
  Sweep sweep;
  EXPECT_FALSE(decoder.pull(sweep));

  std::vector<uint8_t> early = good;  // early firmware
  early[1205] = 0x21;
  push(early, 0x0A000007);
  EXPECT_EQ(counters.packets, 1U);
  decoder.add_kernel_dropped(12, true);
  EXPECT_EQ(counters.lost_kernel, 12U);
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

TEST(Decoder, TheTopOfTheHourIsNotAGap) {
  const Scene before = make_model_scene(Model::kHdl32e, {.turns = 2, .start_us = 100});
  const Scene across = make_model_scene(Model::kHdl32e, {.turns = 2, .start_us = 3'599'900'100});
  Decoder first({.model = &lidar_model(Model::kHdl32e)});
  Decoder second({.model = &lidar_model(Model::kHdl32e)});
  const std::vector<Sweep> expected = assemble(first, before.packets);
  const std::vector<Sweep> sweeps = assemble(second, across.packets);
  EXPECT_EQ(second.counters().lost_network, 0U);
  EXPECT_EQ(second.counters().clock_jumps, 0U);
  ASSERT_EQ(sweeps.size(), expected.size());
  for (size_t i = 0; i < sweeps.size(); ++i) {
    EXPECT_TRUE(same_returns(sweeps[i], expected[i])) << i;
    EXPECT_LE(std::abs((sweeps[i].stamp - expected[i].stamp).count()), 2000);
  }
}

TEST(Decoder, ACounterThatIsSetEndsTheSweepWithoutLoss) {
  Scene scene = make_model_scene(Model::kHdl32e, {.turns = 2, .start_us = 5'000'000});
  for (size_t i = 200; i < scene.packets.size(); ++i) {
    uint8_t* counter = scene.packets[i].payload.data() + 1200;
    const uint32_t value = read_u32(counter) + 1'430'000'000;
    for (size_t k = 0; k < 4; ++k) counter[k] = static_cast<uint8_t>(value >> (8 * k));
  }
  Decoder decoder({.model = &lidar_model(Model::kHdl32e)});
  const std::vector<Sweep> sweeps = assemble(decoder, scene.packets);
  EXPECT_EQ(decoder.counters().clock_jumps, 1U);
  EXPECT_EQ(decoder.counters().lost_network, 0U);
  EXPECT_EQ(decoder.counters().packets, scene.packets.size());
  for (const Sweep& sweep : sweeps) EXPECT_LE(sweep.span, Duration(101'000'000));
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

TEST(Decoder, AStrayAzimuthIsInterpolatedAndCounted) {
  const Scene scene = make_model_scene(Model::kHdl32e, {.turns = 2});
  Decoder undisturbed({.model = &lidar_model(Model::kHdl32e)});
  const std::vector<Sweep> expected = assemble(undisturbed, scene.packets);
  for (const size_t block : {size_t{0}, size_t{5}, size_t{11}}) {
    for (const uint16_t azimuth : {uint16_t{12'345}, uint16_t{36'001}, uint16_t{65'000}}) {
      Scene disturbed = scene;
      fixtures::write_u16(&disturbed.packets[100].payload[block * 100 + 2], azimuth);
      Decoder decoder({.model = &lidar_model(Model::kHdl32e)});
      const std::vector<Sweep> sweeps = assemble(decoder, disturbed.packets);
      EXPECT_EQ(decoder.counters().stray_azimuths, 1U) << block << " " << azimuth;
      EXPECT_EQ(decoder.counters().malformed, 0U);
      EXPECT_EQ(decoder.counters().lost_network, 0U);
      ASSERT_EQ(sweeps.size(), expected.size());
      for (size_t i = 0; i < sweeps.size(); ++i) {
        ASSERT_EQ(sweeps[i].size(), expected[i].size());
        for (size_t k = 0; k < sweeps[i].size(); ++k) {
          ASSERT_NEAR(sweeps[i].x[k], expected[i].x[k], 0.02);  // 0.01° at 100 m
          ASSERT_NEAR(sweeps[i].y[k], expected[i].y[k], 0.02);
          ASSERT_EQ(sweeps[i].time_offset_ns[k], expected[i].time_offset_ns[k]);
        }
      }
    }
  }
}

TEST(Decoder, ARefusedPacketIsNotLost) {
  Scene scene = make_model_scene(Model::kHdl32e, {.turns = 1});
  scene.packets[50].payload[300] = 0;
  scene.packets.erase(scene.packets.begin() + 80, scene.packets.begin() + 83);
  Decoder decoder({.model = &lidar_model(Model::kHdl32e)});
  assemble(decoder, scene.packets);
  EXPECT_EQ(decoder.counters().malformed, 1U);
  EXPECT_EQ(decoder.counters().lost_network, 3U);
}

TEST(Decoder, PushingWithoutPullingIsAProgrammingError) {
  const Scene scene = make_model_scene(Model::kHdl32e, {.turns = 0.1});
  Decoder decoder({.model = &lidar_model(Model::kHdl32e)});
  decoder.push(scene.packets[0].datagram());
  decoder.push(scene.packets[1].datagram());
  EXPECT_THROW(decoder.push(scene.packets[2].datagram()), std::logic_error);
}

TEST(Decoder, OptionsReportWhatIsInvalid) {
  EXPECT_FALSE(lidar::DecoderOptions().invalid());
  EXPECT_FALSE((lidar::DecoderOptions{.cut_azimuth = -90}).invalid());
  EXPECT_TRUE((lidar::DecoderOptions{.cut_azimuth = -361}).invalid());
  EXPECT_TRUE((lidar::DecoderOptions{.cut_azimuth = std::nan("")}).invalid());
  EXPECT_TRUE((lidar::DecoderOptions{.max_span = Duration(0)}).invalid());
  EXPECT_FALSE(
      lidar::make_decoder({.model = &lidar_model(Model::kHdl32e), .max_span = Duration(0)}));
}

TEST(Decoder, RefusesTheCalibrationOfAnotherMaker) {
  const lidar::LidarModel* model = &lidar_model(Model::kHdl64eS3);
  const auto own = share(Model::kHdl64eS3, built_in_calibration(Model::kHdl64eS3));
  EXPECT_TRUE(lidar::make_decoder({.model = model, .calibration = own}));
  const auto foreign = std::make_shared<lidar::UnitCalibration>(nullptr);
  EXPECT_FALSE(lidar::make_decoder({.model = model, .calibration = foreign}));
}

}  // namespace
}  // namespace infuse::velodyne
