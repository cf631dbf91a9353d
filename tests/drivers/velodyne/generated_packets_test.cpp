// Generated packets with known truth, compared with plain formulas in double precision.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "drivers/measurement/angles.hpp"
#include "drivers/velodyne/decoder.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"
#include "tests/drivers/lidar/assemble.hpp"
#include "tests/drivers/velodyne/oracle.hpp"
#include "tests/drivers/velodyne/share.hpp"

namespace infuse::velodyne {
namespace {

// At the end of the stream the turn during the last sequence is unknown: that of the previous one
// is used, in whole hundredths of a degree.
double azimuth_tolerance(const Sweep& sweep, size_t i, const ModelInfo& info, bool stream_ends) {
  const bool last = stream_ends && sweep.column[i] + info.firings >= sweep.columns;
  return last ? 0.011 * kDegree : 0;
}

void expect_sweep(const Sweep& sweep, const ExpectedSweep& expected, int64_t first_ns,
                  const ModelInfo& info, int64_t time_tolerance_ns, bool stream_ends) {
  ASSERT_EQ(sweep.size(), expected.size());
  const double half_unit = info.distance_unit_mm * 0.5e-3;
  size_t wrong = 0;
  for (size_t i = 0; i < sweep.size() && wrong < 5; ++i) {
    const auto at = expected.find({sweep.column[i], sweep.ring[i], sweep.return_kind[i]});
    if (at == expected.end()) {
      ADD_FAILURE() << "column " << sweep.column[i] << " ring " << sweep.ring[i];
      ++wrong;
      continue;
    }
    const ExpectedReturn& e = at->second;
    const double near = 5e-5 + e.range * azimuth_tolerance(sweep, i, info, stream_ends);
    const bool good =
        std::abs(sweep.x[i] - e.x) < near && std::abs(sweep.y[i] - e.y) < near &&
        std::abs(sweep.z[i] - e.z) < 5e-5 && std::abs(sweep.range[i] - e.range) < half_unit &&
        std::abs(sweep.reflectivity[i] - e.reflectivity) < 2e-6 &&
        std::abs(sweep.time_offset_ns[i] - (e.time_ns - first_ns)) <= time_tolerance_ns &&
        std::abs(e.azimuth - e.true_azimuth) < 0.0101;
    if (!good) ++wrong;
    EXPECT_TRUE(good) << "return " << i << " at " << sweep.x[i] << " " << sweep.y[i] << " "
                      << sweep.z[i] << " " << sweep.range[i] << " " << sweep.reflectivity[i] << " "
                      << sweep.time_offset_ns[i] << ", expected " << e.x << " " << e.y << " " << e.z
                      << " " << e.range << " " << e.reflectivity << " " << e.time_ns - first_ns
                      << ", azimuth " << e.azimuth << " for " << e.true_azimuth;
  }
}

struct Case {
  Model model;
  ReturnMode mode;
  double turns_per_second;
};

std::string case_name(const testing::TestParamInfo<Case>& info) {
  std::string name = model_info(info.param.model).name;
  name += info.param.mode == ReturnMode::kDual   ? "_dual_"
          : info.param.mode == ReturnMode::kLast ? "_last_"
                                                 : "_strongest_";
  name += std::to_string(static_cast<int>(info.param.turns_per_second)) + "Hz";
  std::erase_if(name, [](char c) { return c == '-' || c == ' '; });
  return name;
}

class GeneratedPackets : public testing::TestWithParam<Case> {};

TEST_P(GeneratedPackets, EveryReturnHasTheExactPositionTimeAndKind) {
  const Case& param = GetParam();
  const ModelInfo& info = model_info(param.model);
  SceneOptions options;
  options.model = param.model;
  options.mode = param.mode;
  options.turns_per_second = param.turns_per_second;
  options.turns = param.model == Model::kVls128 ? 0.3 : 1.2;
  options.calibration = built_in_calibration(param.model);
  const Scene scene = make_scene(options);

  Decoder decoder(
      {.model = &lidar_model(param.model), .calibration = share(param.model, options.calibration)});
  const std::vector<Sweep> sweeps = assemble(decoder, scene.packets);
  EXPECT_EQ(decoder.counters().packets, scene.packets.size());
  EXPECT_EQ(decoder.counters().lost_network, 0U);
  ASSERT_EQ(sweeps.size(), scene.sweeps.size());
  ASSERT_GE(sweeps.size(), 2U);
  for (size_t i = 0; i < sweeps.size(); ++i) {
    EXPECT_EQ(sweeps[i].rings, info.lasers);
    EXPECT_EQ(sweeps[i].sequence, i);
    expect_sweep(sweeps[i], scene.sweeps[i], scene.starts_ns[i], info, 1, i + 1 == sweeps.size());
  }
}

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  for (const ModelInfo& info : models()) {
    for (const double rate : {5.0, 10.0, 20.0}) {
      cases.push_back({info.model, ReturnMode::kStrongest, rate});
      if (info.has_dual_return) cases.push_back({info.model, ReturnMode::kDual, rate});
    }
    if (!info.calibrated_per_unit) cases.push_back({info.model, ReturnMode::kLast, 10});
  }
  return cases;
}

INSTANTIATE_TEST_SUITE_P(AllModels, GeneratedPackets, testing::ValuesIn(all_cases()), case_name);

}  // namespace
}  // namespace infuse::velodyne
