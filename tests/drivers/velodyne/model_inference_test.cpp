#include "drivers/velodyne/model_inference.hpp"

#include <gtest/gtest.h>

#include "tests/drivers/velodyne/oracle.hpp"

namespace infuse::velodyne {
namespace {

std::optional<InferredModel> infer(const Scene& scene, std::optional<uint8_t> product = {}) {
  ModelInference inference;
  for (SentPacket packet : scene.packets) {
    if (product) packet.payload[1205] = *product;
    inference.add(packet.payload);
  }
  return inference.infer();
}

TEST(ModelInference, InfersEveryModelFromItsPackets) {
  for (const ModelInfo& info : models()) {
    for (const ReturnMode mode : {ReturnMode::kStrongest, ReturnMode::kDual}) {
      if (mode == ReturnMode::kDual && !info.has_dual_return) continue;
      const auto inferred = infer(make_scene({.model = info.model,
                                              .mode = mode,
                                              .turns = 0.3,
                                              .calibration = built_in_calibration(info.model)}));
      ASSERT_TRUE(inferred) << info.name;
      EXPECT_EQ(inferred->model, info.model) << inferred->reason;
      EXPECT_FALSE(inferred->reason.empty());
    }
  }
}

TEST(ModelInference, RecognisesEarlyVlp16Firmware) {
  for (const ReturnMode mode : {ReturnMode::kStrongest, ReturnMode::kDual}) {
    const auto inferred = infer(make_scene({.model = Model::kVlp16,
                                            .mode = mode,
                                            .calibration = built_in_calibration(Model::kVlp16)}),
                                uint8_t{0x21});
    ASSERT_TRUE(inferred);
    EXPECT_EQ(inferred->model, Model::kVlp16);
    EXPECT_NE(inferred->reason.find("0x21"), std::string::npos) << inferred->reason;
  }
}

TEST(ModelInference, GivesNoModelForTooFewPacketsOrOtherData) {
  const Scene scene = make_scene({.turns = 1, .calibration = built_in_calibration(Model::kHdl32e)});
  ModelInference inference;
  EXPECT_FALSE(inference.infer());
  for (size_t i = 0; i < 7; ++i) inference.add(scene.packets[i].payload);
  EXPECT_FALSE(inference.infer());
  for (size_t i = 7; i < 64; ++i) inference.add(scene.packets[i].payload);
  EXPECT_FALSE(infer(scene, uint8_t{0x99}));

  ModelInference noise;
  for (size_t i = 0; i < 100; ++i) noise.add(std::vector<uint8_t>(kPacketSize, 7));
  EXPECT_FALSE(noise.infer());
}

}  // namespace
}  // namespace infuse::velodyne
