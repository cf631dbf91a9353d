#include "drivers/velodyne/model_inference.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"

#include <gtest/gtest.h>

#include "tests/drivers/velodyne/oracle.hpp"

namespace infuse::velodyne {
namespace {

std::optional<lidar::InferredModel> infer(const Scene& scene, std::optional<uint8_t> product = {}) {
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
      EXPECT_EQ(model_of(*inferred->model), info.model) << inferred->reason;
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
    EXPECT_EQ(model_of(*inferred->model), Model::kVlp16);
    EXPECT_NE(inferred->reason.find("0x21"), std::string::npos) << inferred->reason;
  }
}

TEST(ModelInference, AMajorityDecides) {
  Scene scene = make_scene(
      {.model = Model::kVlp16, .turns = 0.5, .calibration = built_in_calibration(Model::kVlp16)});
  scene.packets[5].payload[300] = 0xFF;  // the flag of lasers 96 … 127
  scene.packets[5].payload[301] = 0xBB;
  scene.packets.back().payload[1205] = 0x77;
  const auto inferred = infer(scene);
  ASSERT_TRUE(inferred);
  EXPECT_EQ(model_of(*inferred->model), Model::kVlp16) << inferred->reason;
}

TEST(ModelInference, MeasuresTheRateOfTurningWhateverTheModel) {
  for (const double rate : {5.0, 9.99, 20.0}) {
    ModelInference inference;
    for (const SentPacket& packet : make_scene({.model = Model::kVlp16,
                                    .turns_per_second = rate,
                                    .turns = 2,
                                    .calibration = built_in_calibration(Model::kVlp16)})
                                        .packets) {
      inference.add(packet.payload);
    }
    EXPECT_NEAR(inference.turns_per_second(), rate, 0.005 * rate);
    EXPECT_FALSE(inference.has_two_sensors());
  }
}

TEST(ModelInference, TwoSensorsOfOneAddressAreRecognised) {
  const Calibration& calibration = built_in_calibration(Model::kHdl32e);
  const Scene one = make_scene({.turns = 1, .calibration = calibration});
  // The same clock and another azimuth; then another clock too.
  for (const uint32_t start_us : {uint32_t{250}, uint32_t{1'234'567'890}}) {
    const Scene other = make_scene({.start_azimuth = 77,
                                    .turns = 1,
                                    .start_us = start_us,
                                    .calibration = calibration,
                                    .seed = 2});
    ModelInference inference;
    for (size_t i = 0; i < one.packets.size(); ++i) {
      inference.add(one.packets[i].payload);
      inference.add(other.packets[i].payload);
    }
    EXPECT_TRUE(inference.has_two_sensors()) << start_us;
    EXPECT_EQ(inference.judge(), &lidar_model(Model::kHdl32e));
    EXPECT_NEAR(inference.turns_per_second(), 10, 0.05);
  }
}

/// One model alone has the timing of an HDL-32E; that of a VLP-16 is a Puck Hi-Res' too.
TEST(ModelInference, AnUnknownProductByteLeavesTheTimingToDecide) {
  const Scene hdl = make_scene({.turns = 1, .calibration = built_in_calibration(Model::kHdl32e)});
  const auto inferred = infer(hdl, uint8_t{0x99});
  ASSERT_TRUE(inferred);
  EXPECT_EQ(inferred->model, &lidar_model(Model::kHdl32e));
  EXPECT_NE(inferred->reason.find("product byte 0x99 says no known model"), std::string::npos);
  const Scene vlp = make_scene(
      {.model = Model::kVlp16, .turns = 1, .calibration = built_in_calibration(Model::kVlp16)});
  EXPECT_FALSE(infer(vlp, uint8_t{0x99}));
}

TEST(ModelInference, GivesNoModelForTooFewPacketsOrOtherData) {
  const Scene scene = make_scene({.turns = 1, .calibration = built_in_calibration(Model::kHdl32e)});
  ModelInference inference;
  EXPECT_FALSE(inference.infer());
  for (size_t i = 0; i < 7; ++i) inference.add(scene.packets[i].payload);
  EXPECT_FALSE(inference.infer());
  for (size_t i = 7; i < 64; ++i) inference.add(scene.packets[i].payload);

  ModelInference noise;
  for (size_t i = 0; i < 100; ++i) noise.add(std::vector<uint8_t>(kPacketSize, 7));
  EXPECT_FALSE(noise.infer());
}

}  // namespace
}  // namespace infuse::velodyne
