// Every packet that went wrong in a known way is used, or refused with its reason.

#include "tests/drivers/velodyne/mutation_families.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "drivers/velodyne/decoder.hpp"
#include "drivers/velodyne/model_inference.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"

namespace infuse::velodyne {
namespace {

class MutationFamilies : public testing::TestWithParam<MutationFamily> {};

TEST_P(MutationFamilies, EveryPacketIsUsedOrCounted) {
  std::mt19937 random(7);
  for (const ModelInfo& info : models()) {
    for (const ReturnMode mode : {ReturnMode::kStrongest, ReturnMode::kDual}) {
      if (mode == ReturnMode::kDual && !info.has_dual_return) continue;
      auto packets = make_scene({.model = info.model,
                                 .mode = mode,
                                 .turns = 0.1,
                                 .calibration = built_in_calibration(info.model)})
                         .packets;
      GetParam().apply(packets, random);
      Decoder decoder({.model = &lidar_model(info.model)});
      ModelInference inference;
      Sweep sweep;
      const auto check_sweeps = [&] {
        while (decoder.pull(sweep)) {
          for (size_t i = 0; i < sweep.size(); ++i) {
            ASSERT_TRUE(std::isfinite(sweep.x[i] + sweep.y[i] + sweep.z[i]));
            ASSERT_LT(sweep.column[i], sweep.columns);
            ASSERT_LT(sweep.ring[i], sweep.rings);
          }
        }
      };
      for (const SentPacket& packet : packets) {
        decoder.push(packet.datagram());
        inference.add(packet.payload);
        check_sweeps();
      }
      decoder.finish();
      check_sweeps();
      const lidar::PacketCounters& c = decoder.counters();
      EXPECT_EQ(c.packets + c.malformed + c.duplicates + c.too_late + c.position_packets,
                packets.size())
          << info.name;
      EXPECT_FALSE(inference.describe().empty());
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, MutationFamilies,
                         testing::ValuesIn(mutation_families().begin(), mutation_families().end()),
                         [](const auto& family) { return std::string(family.param.name); });

TEST(MutationFamilies, AFewProductBytesAndFlagsDoNotChangeTheInferredModel) {
  std::mt19937 random(3);
  for (const ModelInfo& info : models()) {
    for (const auto apply : {mutation::product_bytes, mutation::one_flag, mutation::stray_azimuths,
                             mutation::other_lengths}) {
      const SceneOptions options{
          .model = info.model, .turns = 0.6, .calibration = built_in_calibration(info.model)};
      auto packets = make_scene(options).packets;
      ModelInference sound, mutated;
      for (const SentPacket& packet : packets) sound.add(packet.payload);
      apply(packets, random);
      for (const SentPacket& packet : packets) {
        if (packet.payload.size() == kPacketSize) mutated.add(packet.payload);
      }
      const auto expected = sound.infer();
      const auto found = mutated.infer();
      ASSERT_TRUE(expected && found) << info.name << ": " << mutated.describe();
      EXPECT_EQ(found->model, expected->model) << info.name;
    }
  }
}

}  // namespace
}  // namespace infuse::velodyne
