#include <gtest/gtest.h>

#include <cmath>

#include "drivers/velodyne/velodyne_maker.hpp"
#include "fixtures/simulator/simulation.hpp"
#include "fusion/features/air_returns.hpp"

namespace infuse::study {
namespace {

/// Shares of the returns up to 12 m that are left out.
struct Left {
  double air = 0, surface = 0;
};

/// Turns along a street of an invented town in winter; what is of the air the simulator states.
/// The options were chosen on other streets.

Left leave_out(velodyne::Model model, double rate, const simulator::AirOptions& air) {
  simulator::Scenario s;
  s.seed = 31;
  s.world_seed = 9;
  s.duration = 20;
  s.town = {.size = 250, .block = 100};
  s.route_length = 150;
  s.street.build_radius = 40;
  s.street.ground_resolution = 1;
  s.street.season = {.season = simulator::Season::kWinter, .snow = 0.5};
  s.motion.start_speed = 8;
  s.air = air;
  simulator::LidarOptions lidar;
  lidar.model = &velodyne::lidar_model(model);
  lidar.rate = rate;
  lidar.rays_per_pulse = 1;
  lidar.T_vehicle_lidar.translation() = Eigen::Vector3d(0.8, 0, 1.9);
  s.lidars.push_back(lidar);
  auto simulation = simulator::Simulation::create(s);
  EXPECT_TRUE(simulation.has_value());
  features::AirReturns filter;
  double out[2] = {0, 0}, all[2] = {0, 0};
  for (const uint64_t turn : {0U, 50U, 100U}) {
    const simulator::LidarBlock block = simulation->scan_turn(0, turn);
    const Sweep sweep = simulation->lidars().front().to_sweep(block, Stamp());
    filter.find(sweep);
    const auto x = filter.without(sweep.x);
    size_t i = 0;
    for (const simulator::LidarReturn& r : block.strongest) {
      if (r.range <= 0) continue;
      EXPECT_EQ(sweep.range[i], r.range);
      const size_t kind = r.label == simulator::Label::kNothing ? 1 : 0;
      if (r.range <= 12) {
        all[kind] += 1;
        out[kind] += std::isnan(x[i]) ? 1 : 0;
      }
      ++i;
    }
  }
  return {all[1] > 0 ? out[1] / all[1] : 0, out[0] / all[0]};
}

TEST(FogInTheSimulator, IsLeftOutAndTheStreetIsNot) {
  for (const auto& [model, rate] :
       {std::pair(velodyne::Model::kHdl32e, 10.0), std::pair(velodyne::Model::kVlp16, 20.0),
        std::pair(velodyne::Model::kHdl64eS2, 10.0)}) {
    for (const double visibility : {100.0, 200.0, 400.0}) {
      const Left left = leave_out(model, rate, {.fog_visibility = visibility});
      EXPECT_GT(left.air, 0.97) << static_cast<int>(model) << ", " << visibility;
      EXPECT_LT(left.surface, 0.04) << static_cast<int>(model) << ", " << visibility;
    }
    EXPECT_EQ(leave_out(model, rate, {}).surface, 0);
  }
}

}  // namespace
}  // namespace infuse::study
