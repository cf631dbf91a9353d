#include "drivers/measurement/angles.hpp"
#include "drivers/velodyne/decoder.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include "fixtures/lidar/little_endian.hpp"
#include "tests/drivers/lidar/assemble.hpp"
#include "tests/drivers/velodyne/model_scene.hpp"
#include "tests/drivers/velodyne/oracle.hpp"
#include "tests/drivers/velodyne/share.hpp"

namespace infuse::velodyne {
namespace {

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
