#include "drivers/hesai/decoder.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "drivers/hesai/hesai_maker.hpp"
#include "drivers/lidar/lidar_maker.hpp"
#include "tests/allocation_counter.hpp"
#include "tests/drivers/hesai/made_turns.hpp"
#include "tests/drivers/hesai/oracle.hpp"
#include "tests/drivers/lidar/assemble.hpp"

namespace infuse::hesai {
namespace {

std::vector<PlainFiring> plain_firings(Model model, const std::vector<SentPacket>& packets) {
  std::vector<PlainFiring> firings;
  for (const SentPacket& packet : packets) {
    for (PlainFiring& firing : plain_decode(model, packet.payload, built_in_angles(model))) {
      firings.push_back(std::move(firing));
    }
  }
  return firings;
}

struct Case {
  Model model;
  ReturnMode mode;
};

class HesaiDecoder : public testing::TestWithParam<Case> {};

TEST_P(HesaiDecoder, GivesEveryReturnOfThePackets) {
  const auto [model, mode] = GetParam();
  const auto packets = make_turns(model, mode, 1.3);
  for (const InstructionSet set : {InstructionSet::kBaseline, InstructionSet::kAvx2}) {
    if (!supported(set)) continue;
    Decoder decoder({.model = &lidar_model(model), .instruction_set = set});
    const auto sweeps = assemble(decoder, packets);
    ASSERT_EQ(sweeps.size(), 3u);
    EXPECT_EQ(sweeps[0].rings, lasers_of(model));
    const size_t compared =
        expect_equal(model, mode, sweeps, plain_firings(model, packets), built_in_angles(model));
    EXPECT_GT(compared, 1'000u);
    EXPECT_TRUE(sweeps[1].gaps.empty());
    EXPECT_EQ(decoder.counters().packets, packets.size());
    EXPECT_EQ(decoder.counters().malformed, 0u);
    EXPECT_EQ(decoder.counters().lost_network, 0u);
    EXPECT_EQ(decoder.counters().stray_azimuths, 0u);
  }
}

INSTANTIATE_TEST_SUITE_P(Modes, HesaiDecoder,
                         testing::Values(Case{Model::kPandar40p, ReturnMode::kStrongest},
                                         Case{Model::kPandar40p, ReturnMode::kLastStrongest},
                                         Case{Model::kPandar64, ReturnMode::kLast},
                                         Case{Model::kPandar64, ReturnMode::kLastStrongest},
                                         Case{Model::kQt64, ReturnMode::kFirst},
                                         Case{Model::kQt64, ReturnMode::kFirstLast},
                                         Case{Model::kQt128, ReturnMode::kStrongest},
                                         Case{Model::kQt128, ReturnMode::kStrongestSecond},
                                         Case{Model::kXt16, ReturnMode::kStrongest},
                                         Case{Model::kXt16, ReturnMode::kFirstLast},
                                         Case{Model::kXt32, ReturnMode::kStrongest},
                                         Case{Model::kXt32, ReturnMode::kLastStrongest},
                                         Case{Model::kXt32m, ReturnMode::kStrongest},
                                         Case{Model::kXt32m, ReturnMode::kFirstStrongest},
                                         Case{Model::kXt32m, ReturnMode::kFirstLastStrongest}));

TEST(HesaiDecoding, CountsLossesByNumberAndWithoutOneByTime) {
  for (const bool has_number : {false, true}) {
    for (const Model model : {Model::kPandar40p, Model::kXt32, Model::kQt128}) {
      auto packets = make_turns(model, ReturnMode::kStrongest, 2.5, has_number);
      const auto middle = packets.begin() + static_cast<ptrdiff_t>(packets.size() / 2);
      packets.erase(middle, middle + 5);
      Decoder decoder({.model = &lidar_model(model)});
      const auto sweeps = assemble(decoder, packets);
      EXPECT_EQ(decoder.counters().lost_network, 5u) << model_info(model).name << has_number;
      uint32_t lost = 0;
      size_t gaps = 0;
      for (const Sweep& sweep : sweeps) lost += sweep.lost_packets;
      for (size_t i = 1; i + 1 < sweeps.size(); ++i) gaps += sweeps[i].gaps.size();
      EXPECT_EQ(lost, 5u);
      EXPECT_EQ(gaps, 1u);
      expect_equal(model, ReturnMode::kStrongest, sweeps, plain_firings(model, packets),
                   built_in_angles(model));
    }
  }
}

TEST(HesaiDecoding, CountsDamageByItsCause) {
  auto packets = make_turns(Model::kXt32, ReturnMode::kStrongest, 0.5);
  const size_t all = packets.size();
  packets[10].payload.resize(700);
  packets[11].payload[7] = 3;                       // number of blocks
  packets[12].payload[12 + 8 * 130 + 10] = 0;       // return mode
  packets[13].payload[12 + 8 * 130 + 13 + 1] = 20;  // month
  packets[20].payload[12 + 130 * 3] = 0xFF;         // one azimuth
  packets[20].payload[12 + 130 * 3 + 1] = 0xFF;
  packets[30] = packets[29];
  std::swap(packets[40], packets[41]);
  Decoder decoder({.model = &lidar_model(Model::kXt32)});
  const auto sweeps = assemble(decoder, packets);
  const lidar::PacketCounters& counters = decoder.counters();
  EXPECT_EQ(counters.malformed, 4u);
  EXPECT_EQ(counters.stray_azimuths, 1u);
  EXPECT_EQ(counters.duplicates, 1u);
  EXPECT_EQ(counters.out_of_order, 1u);
  EXPECT_EQ(counters.packets, all - 5);
  EXPECT_EQ(counters.lost_network, 1u);  // in whose place the duplicate came
}

TEST(HesaiDecoding, ReadsSentencesOfGpsPackets) {
  Decoder decoder({.model = &lidar_model(Model::kXt32)});
  std::vector<uint8_t> gps(512);
  gps[0] = 0xFF;
  gps[1] = 0xEE;
  const std::string sentence =
      "$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A\r\n";
  std::copy(sentence.begin(), sentence.end(), gps.begin() + 18);
  const SentPacket packet{Stamp::from_ns(5'000), gps, 10'110};
  decoder.push(packet.datagram());
  GnssFix fix;
  ASSERT_TRUE(decoder.pull(fix));
  EXPECT_EQ(fix.stamp, Stamp::from_ns(5'000));
  EXPECT_TRUE(fix.valid);
  EXPECT_EQ(decoder.counters().position_packets, 1u);
  decoder.push(packet.datagram());
  EXPECT_FALSE(decoder.pull(fix)) << "the same sentence again";
}

TEST(HesaiDecoding, KnowsThatTheDeviceHasUtc) {
  auto packets = make_turns(Model::kXt32, ReturnMode::kStrongest, 0.2);
  const int64_t device_ns = 1'564'024'769'000'000'000;
  for (SentPacket& packet : packets) {
    packet.stamp = packet.stamp - Duration(1'700'000'000'000'000'000 - device_ns);
  }
  Decoder decoder({.model = &lidar_model(Model::kXt32)});
  assemble(decoder, packets);
  EXPECT_EQ(decoder.clock().source, ClockState::Source::kUtc);
  Decoder unset({.model = &lidar_model(Model::kXt32)});
  assemble(unset, make_turns(Model::kXt32, ReturnMode::kStrongest, 0.2));
  EXPECT_EQ(unset.clock().source, ClockState::Source::kPowerUp);
}

TEST(HesaiDecoding, AllocatesNothingAfterTheFirstSweeps) {
  for (const Model model : {Model::kXt32, Model::kPandar40p, Model::kQt128}) {
    auto packets = make_turns(model, ReturnMode::kLastStrongest, 6);
    for (size_t i = 100; i < packets.size(); i += 50) packets[i].payload[i % 1'000] ^= 0x55;
    Decoder decoder({.model = &lidar_model(model)});
    std::array<Sweep, 2> slots;
    size_t sweeps = 0;
    size_t warm = 0;
    for (const SentPacket& packet : packets) {
      decoder.push(packet.datagram());
      while (decoder.pull(slots[sweeps % 2])) {
        if (++sweeps == 4) warm = allocation_count();
      }
    }
    ASSERT_GE(sweeps, 5u);
    if (kAllocationsCounted) {
      EXPECT_GT(warm, 0u);
    }
    EXPECT_EQ(allocation_count(), warm) << model_info(model).name;
  }
}

TEST(HesaiMaker, KnowsItsPackets) {
  const lidar::LidarMaker& hesai = maker();
  EXPECT_EQ(hesai.classify(make_packet({})), lidar::PacketClass::kData);
  std::vector<uint8_t> gps(512);
  EXPECT_EQ(hesai.classify(gps), lidar::PacketClass::kOther);
  gps[0] = 0xFF;
  gps[1] = 0xEE;
  EXPECT_EQ(hesai.classify(gps), lidar::PacketClass::kInformation);
  EXPECT_EQ(hesai.first_azimuth(make_packet({.azimuths = {1'234}})), 1'234);
  for (const ModelInfo& info : models()) {
    const auto inference = hesai.make_inference();
    for (const SentPacket& packet : make_turns(info.model, ReturnMode::kLastStrongest, 0.3)) {
      inference->add(packet.payload);
    }
    EXPECT_EQ(inference->judge(), &lidar_model(info.model));
    EXPECT_NEAR(inference->turns_per_second(), 10, 0.1) << info.name;
    EXPECT_FALSE(inference->has_two_sensors());
    EXPECT_NE(inference->describe().find("last and strongest returns, 10.0 turns per second"),
              std::string::npos)
        << inference->describe();
  }
}

TEST(HesaiMaker, RefusesAnotherModelsCalibration) {
  const auto unit =
      std::make_shared<UnitCalibration>(Model::kXt16, built_in_calibration(Model::kXt16));
  EXPECT_TRUE(lidar::make_decoder({.model = &lidar_model(Model::kXt16), .calibration = unit}));
  EXPECT_FALSE(lidar::make_decoder({.model = &lidar_model(Model::kXt32), .calibration = unit}));
}

}  // namespace
}  // namespace infuse::hesai
