#include "drivers/velodyne/firing_cycle_estimator.hpp"
#include "drivers/velodyne/decoder.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"

#include <gtest/gtest.h>

#include "tests/drivers/lidar/assemble.hpp"
#include "tests/drivers/velodyne/oracle.hpp"

namespace infuse::velodyne {
namespace {

// VLS-128 firmware determines the cycle: the observed value is used, with or without lost packets.
TEST(FiringCycleEstimator, EstimatesTheCycleFromTheStream) {
  for (const double cycle_us : {53.3, 55.28, 57.8}) {
    for (const ReturnMode mode : {ReturnMode::kStrongest, ReturnMode::kDual}) {
      Scene scene = make_scene({.model = Model::kVls128,
                                .mode = mode,
                                .turns = mode == ReturnMode::kDual ? 0.9 : 2.2,
                                .calibration = built_in_calibration(Model::kVls128),
                                .cycle_us = cycle_us});
      scene.packets.erase(scene.packets.begin() + 100, scene.packets.begin() + 103);
      Decoder decoder({.model = &lidar_model(Model::kVls128)});
      const std::vector<Sweep> sweeps = assemble(decoder, scene.packets);
      EXPECT_NEAR(static_cast<double>(decoder.firing_cycle().count()), cycle_us * 1e3, 2);
      EXPECT_EQ(decoder.counters().lost_network, 3U);
      const Sweep& sweep = sweeps.back();
      // The last firing of the stream: laser 127, 16 of 20 slots into its sequence.
      const int32_t last = sweep.time_offset_ns[sweep.size() - 1];
      EXPECT_NEAR(static_cast<double>(sweep.span.count()), last, 4 * cycle_us * 1e3 / 20);
    }
  }
}

TEST(FiringCycleEstimator, IgnoresPeriodsOfOtherSensors) {
  FiringCycleEstimator cycle(model_info(Model::kVls128));
  for (int i = 0; i < 5'000; ++i) EXPECT_FALSE(cycle.add(400, false));
  int told = 0;
  for (int i = 0; i < 5'000; ++i) told += cycle.add(160, false) ? 1 : 0;
  EXPECT_EQ(told, 1);
}

}  // namespace
}  // namespace infuse::velodyne
