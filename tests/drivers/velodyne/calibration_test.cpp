#include "drivers/velodyne/calibration.hpp"
#include "drivers/measurement/angles.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace infuse::velodyne {
namespace {

std::vector<double> elevations(Model model) {
  std::vector<double> degrees;
  for (size_t laser = 0; laser < model_info(model).lasers; ++laser) {
    degrees.push_back(built_in_calibration(model).beams[laser].elevation / kDegree);
  }
  return degrees;
}

TEST(Calibration, BuiltInBeamsCoverTheManualsFieldOfView) {
  const auto expect_span = [](Model model, double low, double high) {
    const std::vector<double> all = elevations(model);
    EXPECT_NEAR(*std::min_element(all.begin(), all.end()), low, 0.01) << model_info(model).name;
    EXPECT_NEAR(*std::max_element(all.begin(), all.end()), high, 0.01) << model_info(model).name;
  };
  expect_span(Model::kHdl32e, -30.67, 10.67);
  expect_span(Model::kVlp16, -15, 15);
  expect_span(Model::kPuckHiRes, -10, 10);
  expect_span(Model::kVlp32c, -25, 15);
  expect_span(Model::kVls128, -25, 15);
  for (const ModelInfo& info : models()) {
    EXPECT_FALSE(built_in_calibration(info.model).invalid(info)) << info.name;
    const std::vector<double> all = elevations(info.model);
    EXPECT_EQ(std::set<double>(all.begin(), all.end()).size(), info.lasers) << info.name;
  }
  // An HDL-32E's beams rise from −30.67° in steps of 4/3°.
  std::vector<double> hdl32e = elevations(Model::kHdl32e);
  std::sort(hdl32e.begin(), hdl32e.end());
  for (size_t i = 0; i < 32; ++i) {
    EXPECT_NEAR(hdl32e[i], -92.0 / 3 + 4.0 / 3 * static_cast<double>(i), 0.005);
  }
}

TEST(Calibration, AzimuthOffsetsMatchTheManuals) {
  std::set<long> vlp32c;
  for (size_t laser = 0; laser < 32; ++laser) {
    const BeamCorrection& beam = built_in_calibration(Model::kVlp32c).beams[laser];
    vlp32c.insert(std::lround(beam.rotation / kDegree * 1000));
  }
  EXPECT_EQ(vlp32c, (std::set<long>{-4200, -1400, 1400, 4200}));
  std::set<long> vls128;
  for (size_t laser = 0; laser < 128; ++laser) {
    const BeamCorrection& beam = built_in_calibration(Model::kVls128).beams[laser];
    vls128.insert(std::lround(beam.rotation / kDegree * 1000));
  }
  EXPECT_EQ(vls128, (std::set<long>{-6354, -4548, -2732, -911, 911, 2732, 4548, 6354}));
}

TEST(Calibration, RingsCountFromBelow) {
  for (const ModelInfo& info : models()) {
    const Calibration& calibration = built_in_calibration(info.model);
    const auto rings = calibration.rings(info);
    std::vector<double> by_ring(info.lasers);
    for (size_t laser = 0; laser < info.lasers; ++laser) {
      ASSERT_LT(rings[laser], info.lasers);
      by_ring[rings[laser]] = calibration.beams[laser].elevation;
    }
    EXPECT_TRUE(std::is_sorted(by_ring.begin(), by_ring.end())) << info.name;
  }
  const auto vlp16 = built_in_calibration(Model::kVlp16).rings(model_info(Model::kVlp16));
  EXPECT_EQ(vlp16[0], 0);
  EXPECT_EQ(vlp16[1], 8);
  EXPECT_EQ(vlp16[15], 15);
}

TEST(Calibration, ReportsImpossibleNumbers) {
  const ModelInfo& info = model_info(Model::kHdl64eS3);
  Calibration calibration = built_in_calibration(Model::kHdl64eS3);
  calibration.beams[5].rotation = std::numeric_limits<double>::quiet_NaN();
  ASSERT_TRUE(calibration.invalid(info));
  EXPECT_NE(calibration.invalid(info)->find("laser 5"), std::string::npos);
  calibration = built_in_calibration(Model::kHdl64eS3);
  calibration.beams[63].distance_x = 11;
  EXPECT_TRUE(calibration.invalid(info));
  calibration = built_in_calibration(Model::kHdl64eS3);
  calibration.beams[0].min_intensity = 200;
  calibration.beams[0].max_intensity = 100;
  EXPECT_TRUE(calibration.invalid(info));
}

}  // namespace
}  // namespace infuse::velodyne
