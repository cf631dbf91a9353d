#include "drivers/hesai/calibration_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/real_data.hpp"

namespace infuse::hesai {
namespace {

std::string xt16_file() {
  std::string text = "Channel,Elevation,Azimuth\r\n";
  for (int channel = 1; channel <= 16; ++channel) {
    text += std::to_string(channel) + "," + std::to_string(17 - 2 * channel) + ", 0.25\r\n";
  }
  return text;
}

TEST(HesaiAngleFile, IsParsed) {
  const auto calibration = parse_angle_csv(xt16_file(), model_info(Model::kXt16));
  ASSERT_TRUE(calibration) << calibration.error().message();
  EXPECT_NEAR(calibration->beams[0].elevation, 15 * std::numbers::pi / 180, 1e-15);
  EXPECT_NEAR(calibration->beams[15].elevation, -15 * std::numbers::pi / 180, 1e-15);
  EXPECT_NEAR(calibration->beams[7].azimuth_offset, 0.25 * std::numbers::pi / 180, 1e-15);
  const auto rings = calibration->rings(model_info(Model::kXt16));
  EXPECT_EQ(rings[0], 15);
  EXPECT_EQ(rings[15], 0);
}

TEST(HesaiAngleFile, IsRefusedWithTheLineAndTheReason) {
  const ModelInfo& info = model_info(Model::kXt16);
  const auto message = [&](const std::string& text) {
    const auto calibration = parse_angle_csv(text, info);
    return calibration ? "" : calibration.error().message();
  };
  const std::string good = xt16_file();
  EXPECT_NE(message("").find("0 of 16 channels"), std::string::npos);
  EXPECT_NE(message(good + "17,0,0\n").find("line 18: not the angles of a channel of XT16"),
            std::string::npos);
  EXPECT_NE(message(good + "3,0,0\n").find("line 18: channel 3 twice"), std::string::npos);
  EXPECT_NE(message(good.substr(0, good.size() - 15)).find("of 16 channels"), std::string::npos);
  std::string broken = good;
  broken.replace(broken.find("\n9,"), 3, "\n9;");
  EXPECT_NE(message(broken).find("line 10"), std::string::npos);
  std::string steep = good;
  steep.replace(steep.find("1,15,"), 5, "1,95,");
  EXPECT_NE(message(steep).find("elevation of channel 1 is out of range"), std::string::npos);
  std::string twice = good;
  twice.replace(twice.find("1,15,"), 5, "1,13,");
  EXPECT_NE(message(twice).find("channels 1 and 2 have the same direction"), std::string::npos);
  EXPECT_NE(message(std::string(2 << 20, '\n')).find("larger than 1 MiB"), std::string::npos);
  EXPECT_NE(load_angle_csv("/nonexistent.csv", info).error().message().find("/nonexistent.csv"),
            std::string::npos);
}

TEST(HesaiAngleFile, BuiltInAnglesAreValidAndDistinct) {
  for (const ModelInfo& info : models()) {
    const Calibration& calibration = built_in_calibration(info.model);
    EXPECT_EQ(calibration.invalid(info), std::nullopt) << info.name;
    double highest = -1;
    double lowest = 1;
    for (size_t channel = 0; channel < info.lasers; ++channel) {
      highest = std::max(highest, calibration.beams[channel].elevation);
      lowest = std::min(lowest, calibration.beams[channel].elevation);
    }
    EXPECT_GT(highest, 14 * std::numbers::pi / 180) << info.name;
    EXPECT_LT(lowest, -14 * std::numbers::pi / 180) << info.name;
  }
}

TEST(HesaiAngleFile, FilesOfTheMakerAreTheBuiltInAngles) {
  const std::pair<Model, const char*> files[]{
      {Model::kPandar40p, "Pandar40P"}, {Model::kPandar64, "Pandar64"},
      {Model::kQt64, "PandarQT64"},     {Model::kQt128, "PandarQT128"},
      {Model::kXt16, "PandarXT16"},     {Model::kXt32, "PandarXT32"},
      {Model::kXt32m, "PandarXT32M"}};
  for (const auto& [model, name] : files) {
    INFUSE_REAL_DATA_OR_SKIP(path, "lidars/hesai/" + std::string(name) + ".csv");
    const auto calibration = load_angle_csv(path, model_info(model));
    ASSERT_TRUE(calibration) << calibration.error().message();
    for (size_t channel = 0; channel < model_info(model).lasers; ++channel) {
      const BeamAngles& built_in = built_in_calibration(model).beams[channel];
      EXPECT_EQ(calibration->beams[channel].elevation, built_in.elevation) << name << channel;
      EXPECT_EQ(calibration->beams[channel].azimuth_offset, built_in.azimuth_offset);
    }
  }
}

}  // namespace
}  // namespace infuse::hesai
