#include "drivers/robosense/decoder.hpp"

#include <gtest/gtest.h>

#include "drivers/lidar/lidar_maker.hpp"
#include "drivers/robosense/robosense_maker.hpp"
#include "tests/allocation_counter.hpp"
#include "tests/drivers/lidar/assemble.hpp"
#include "tests/drivers/robosense/made_packet.hpp"
#include "tests/drivers/robosense/oracle.hpp"

namespace infuse::robosense {
namespace {

/// Angles of no real unit, 0.01°: elevations fall from channel to channel, but for one pair.
struct MadeAngles {
  explicit MadeAngles(int lasers) {
    for (int i = 0; i < lasers; ++i) {
      elevations.push_back(1'500 - 200 * i + (i == 4 ? -250 : 0));
      azimuths.push_back(i % 2 == 0 ? -401 - i : 358 + i);
    }
  }
  PlainAngles plain() const {
    PlainAngles angles;
    for (size_t i = 0; i < elevations.size(); ++i) {
      angles.emplace_back(elevations[i] * 0.01, azimuths[i] * 0.01);
    }
    return angles;
  }
  SentPacket packet(uint8_t mode, uint32_t sender = 0x0A000007) const {
    return {Stamp::from_ns(1'700'000'000'000'000'000), make_info_packet(elevations, azimuths, mode),
            7788, sender};
  }
  std::vector<int> elevations, azimuths;
};

Model model_of(PlainModel plain) {
  if (plain.bpearl != 0) return plain.bpearl == 4 ? Model::kBpearlV4 : Model::kBpearl;
  return plain.lasers == 16 ? Model::kHelios16p : Model::kHelios;
}

struct Case {
  PlainModel model;
  bool dual;
};

class RobosenseDecoder : public testing::TestWithParam<Case> {};

TEST_P(RobosenseDecoder, GivesEveryReturnAtTheUnitsOwnAngles) {
  const auto [model, dual] = GetParam();
  const MadeAngles angles(model.lasers);
  std::vector<SentPacket> packets = make_turns(model, dual, 1.3);
  const auto firings = plain_decode(model, dual, data_payloads(packets), ReturnKind::kLast);
  packets.insert(packets.begin(), angles.packet(dual ? 0 : model.bpearl == 3 ? 2 : 5));
  for (const InstructionSet set : {InstructionSet::kBaseline, InstructionSet::kAvx2}) {
    if (!supported(set)) continue;
    Decoder decoder({.model = &lidar_model(model_of(model)), .instruction_set = set});
    EXPECT_TRUE(decoder.is_uncalibrated());
    const auto sweeps = assemble(decoder, packets);
    ASSERT_EQ(sweeps.size(), 3u);
    EXPECT_EQ(sweeps[0].rings, model.lasers);
    EXPECT_GT(expect_equal(sweeps, firings, angles.plain(), model), 10'000u);
    EXPECT_TRUE(sweeps[1].gaps.empty());
    EXPECT_FALSE(decoder.is_uncalibrated());
    EXPECT_EQ(decoder.calibration_source(), lidar::CalibrationSource::kStream);
    EXPECT_NE(decoder.streamed_calibration(), nullptr);
    const lidar::PacketCounters& counters = decoder.counters();
    EXPECT_EQ(counters.packets, packets.size() - 1);
    EXPECT_EQ(counters.position_packets, 1u);
    EXPECT_EQ(counters.malformed, 0u);
    EXPECT_EQ(counters.lost_network, 0u);
    EXPECT_EQ(counters.stray_azimuths, 0u);
    EXPECT_EQ(counters.wrong_model, 0u);
    EXPECT_NEAR(counters.turns_hz, 10, 0.02);
  }
}

/// Before an information packet: nominal angles, and the number of returns that packets show.
TEST_P(RobosenseDecoder, KnowsTheNumberOfReturnsFromThePackets) {
  const auto [model, dual] = GetParam();
  const auto packets = make_turns(model, dual, 0.4);
  Decoder decoder({.model = &lidar_model(model_of(model))});
  const auto sweeps = assemble(decoder, packets);
  size_t returns = 0, second = 0;
  for (const Sweep& sweep : sweeps) {
    returns += sweep.size();
    for (size_t i = 0; i < sweep.size(); ++i) {
      second += sweep.return_kind[i] == ReturnKind::kSecondStrongest ? 1 : 0;
    }
  }
  size_t expected = 0;
  for (const PlainFiring& firing : plain_decode(model, dual, data_payloads(packets))) {
    expected += firing.returns.size();
  }
  EXPECT_EQ(returns, expected);
  EXPECT_EQ(second > 0, dual);
  EXPECT_TRUE(decoder.is_uncalibrated());
  EXPECT_EQ(decoder.streamed_calibration(), nullptr);
}

INSTANTIATE_TEST_SUITE_P(Modes, RobosenseDecoder,
                         testing::Values(Case{32, false}, Case{32, true}, Case{16, false},
                                         Case{16, true}, Case{{32, 3}, false}, Case{{32, 3}, true},
                                         Case{{32, 4}, false}, Case{{32, 4}, true}));

TEST(RobosenseDecoding, ABpearlThatTurnsAnticlockwiseIsMirrored) {
  const MadeAngles angles(32);
  const PlainModel model(32, 3);
  std::vector<SentPacket> packets = make_turns(model, false, 0.4);
  const auto firings = plain_decode(model, false, data_payloads(packets));
  packets.insert(packets.begin(), angles.packet(1));
  packets[0].payload[337] = 1;
  Decoder decoder({.model = &lidar_model(Model::kBpearl)});
  EXPECT_GT(expect_equal(assemble(decoder, packets), firings, angles.plain(), model, true), 5'000u);
}

/// Versions before 3 count no packets: all their numbers are 0.
TEST(RobosenseDecoding, LossesWithoutNumbersAreCountedByTime) {
  auto packets = make_turns({32, 3}, false, 2.5);
  for (SentPacket& packet : packets) put(packet.payload, 12, 0, 4);
  const auto middle = packets.begin() + static_cast<ptrdiff_t>(packets.size() / 2);
  packets.erase(middle, middle + 5);
  Decoder decoder({.model = &lidar_model(Model::kBpearl)});
  assemble(decoder, packets);
  EXPECT_EQ(decoder.counters().lost_network, 5u);
  EXPECT_EQ(decoder.counters().duplicates, 0u);
}

TEST(RobosenseDecoding, CountsLossesByNumber) {
  auto packets = make_turns(32, false, 2.5);
  const auto middle = packets.begin() + static_cast<ptrdiff_t>(packets.size() / 2);
  packets.erase(middle, middle + 5);
  Decoder decoder({.model = &lidar_model(Model::kHelios)});
  uint32_t lost = 0;
  for (const Sweep& sweep : assemble(decoder, packets)) lost += sweep.lost_packets;
  EXPECT_EQ(lost, 5u);
  EXPECT_EQ(decoder.counters().lost_network, 5u);
}

TEST(RobosenseDecoding, NoticesAnotherModel) {
  Decoder decoder({.model = &lidar_model(Model::kHelios)});
  const auto packets = make_turns(16, false, 1);
  assemble(decoder, packets);
  EXPECT_EQ(decoder.counters().wrong_model, packets.size());
}

TEST(RobosenseDecoding, AnotherUnitsAnglesAreForgotten) {
  const MadeAngles angles(32);
  Decoder decoder({.model = &lidar_model(Model::kHelios)});
  std::vector<SentPacket> packets = make_turns(32, false, 0.2);
  packets.insert(packets.begin() + 1, angles.packet(4));
  assemble(decoder, packets);
  EXPECT_FALSE(decoder.is_uncalibrated());
  for (SentPacket& packet : packets) {
    packet.sender = 0x0A000008;
    packet.stamp += Duration(20'000'000'000);
  }
  packets.erase(packets.begin() + 1);
  assemble(decoder, packets);
  EXPECT_EQ(decoder.counters().sender_changes, 1u);
  EXPECT_TRUE(decoder.is_uncalibrated());
  EXPECT_EQ(decoder.calibration(), built_in_calibration(Model::kHelios));
}

TEST(RobosenseDecoding, AStreamsCalibrationServesTheNextDecoderFromItsFirstPacket) {
  const MadeAngles angles(16);
  std::vector<SentPacket> packets = make_turns(16, true, 0.5);
  Decoder first({.model = &lidar_model(Model::kHelios16p)});
  assemble(first, std::vector{packets[0], angles.packet(0)});
  Decoder second(
      {.model = &lidar_model(Model::kHelios16p), .calibration = first.streamed_calibration()});
  expect_equal(assemble(second, packets), plain_decode(16, true, data_payloads(packets)),
               angles.plain());
}

TEST(RobosenseDecoding, ASingleOriginIsTheAxis) {
  const auto packets = make_turns(32, false, 0.1);
  Decoder decoder({.model = &lidar_model(Model::kHelios), .single_origin = true});
  const auto sweeps = assemble(decoder, packets);
  ASSERT_FALSE(sweeps.empty());
  for (size_t i = 0; i < sweeps[0].size(); ++i) {
    ASSERT_NEAR(std::hypot(sweeps[0].x[i], sweeps[0].y[i], sweeps[0].z[i]), sweeps[0].range[i],
                1e-4);
  }
}

TEST(RobosenseDecoding, AllocatesNothingAfterWarmUp) {
  const MadeAngles angles(32);
  auto packets = make_turns(32, true, 2.2);
  Decoder decoder({.model = &lidar_model(Model::kHelios)});
  Sweep sweep;
  const size_t warm = packets.size() / 2;
  size_t allocations = 0;
  for (size_t i = 0; i < packets.size(); ++i) {
    const size_t before = allocation_count();
    decoder.push(packets[i].datagram());
    while (decoder.pull(sweep)) sweep.clear();
    if (i > warm) allocations += allocation_count() - before;
  }
  EXPECT_EQ(allocations, 0u);
}

/// Damaged packets are refused or decoded, and each is counted once.
TEST(RobosenseDecoding, DamageIsCounted) {
  std::mt19937 random(5);
  for (const PlainModel& model : {PlainModel(32), PlainModel(16), PlainModel(32, 3)}) {
    auto packets = make_turns(model, random() % 2 == 0, 3);
    size_t damaged = 0;
    for (SentPacket& packet : packets) {
      if (random() % 4 != 0) continue;
      for (int i = 0; i < 5; ++i) packet.payload[random() % 1'248] = static_cast<uint8_t>(random());
      if (random() % 3 == 0) packet.payload.resize(random() % 1'249);
      ++damaged;
    }
    ASSERT_GT(damaged, 10u);
    Decoder decoder({.model = &lidar_model(model_of(model))});
    const auto sweeps = assemble(decoder, packets);
    EXPECT_GE(sweeps.size(), 3u);
    const lidar::PacketCounters& counters = decoder.counters();
    EXPECT_EQ(counters.packets + counters.malformed + counters.duplicates + counters.too_late,
              packets.size());
    EXPECT_GE(counters.packets, packets.size() - damaged);
    EXPECT_GT(counters.malformed, 5u);
  }
}

TEST(RobosenseMaker, RefusesAnotherModelsCalibration) {
  const auto unit = std::make_shared<UnitCalibration>(
      Model::kHelios, built_in_calibration(Model::kHelios), ReturnMode::kLast);
  EXPECT_FALSE(
      lidar::make_decoder({.model = &lidar_model(Model::kHelios16p), .calibration = unit}));
  EXPECT_TRUE(lidar::make_decoder({.model = &lidar_model(Model::kHelios), .calibration = unit}));
}

TEST(RobosenseMaker, InfersTheModelThatPacketsState) {
  const std::vector<uint16_t> azimuths(12, 100);
  const auto infer = [&](uint8_t type, uint8_t model) {
    const auto inference = maker().make_inference();
    for (uint32_t i = 0; i < 20; ++i) {
      inference->add(make_data_packet(i, 1, 700 * i, azimuths, type, model));
    }
    return inference->judge();
  };
  EXPECT_EQ(infer(6, 0), &lidar_model(Model::kHelios));
  EXPECT_EQ(infer(6, 1), &lidar_model(Model::kHelios));
  EXPECT_EQ(infer(6, 3), &lidar_model(Model::kHelios16p));
  EXPECT_EQ(infer(7, 0), &lidar_model(Model::kHelios16p));
  EXPECT_EQ(infer(0, 6), &lidar_model(Model::kHelios));  // newer firmware: one byte further
  EXPECT_EQ(infer(4, 0), nullptr);
  const auto infer_older = [&](uint32_t types) {
    auto packet = make_bpearl_packet(4, 1, 1, 700, azimuths);
    put(packet, 30, types, 3);
    const auto inference = maker().make_inference();
    for (int i = 0; i < 20; ++i) inference->add(packet);
    return inference->judge();
  };
  EXPECT_EQ(infer_older(0x030000), &lidar_model(Model::kBpearl));
  EXPECT_EQ(infer_older(0x000304), &lidar_model(Model::kBpearlV4));
  EXPECT_EQ(infer_older(0x030304), &lidar_model(Model::kBpearlV4));
  EXPECT_EQ(infer_older(0x010000), nullptr);  // RS-LiDAR-16: RoboSense's, but not known
  auto ruby = make_bpearl_packet(4, 1, 1, 700, azimuths);
  put(ruby, 30, 0x040000, 3);
  EXPECT_EQ(maker().classify(ruby), lidar::PacketClass::kData);
}

TEST(RobosenseMaker, TellsPacketsByTheirFirstBytes) {
  const auto data = make_data_packet(0, 1, 2, std::vector<uint16_t>(12, 17'000));
  auto info = make_info_packet({}, {});
  EXPECT_EQ(maker().classify(data), lidar::PacketClass::kData);
  EXPECT_EQ(maker().classify(info), lidar::PacketClass::kInformation);
  // Another length is of another model, which is not known.
  EXPECT_EQ(maker().classify(std::span(data).first(1'247)), lidar::PacketClass::kData);
  EXPECT_EQ(maker().read_stated(std::span(data).first(1'247))->model, nullptr);
  EXPECT_EQ(maker().classify(std::span(data).first(900)), lidar::PacketClass::kOther);
  EXPECT_EQ(maker().first_azimuth(data), 17'000);
  info.resize(2'000);
  const auto found = maker().find_packet(info);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->packet_class, lidar::PacketClass::kInformation);
  EXPECT_EQ(found->size, 1'248u);
  info[7] = 0;
  EXPECT_FALSE(maker().find_packet(info));
}

}  // namespace
}  // namespace infuse::robosense
