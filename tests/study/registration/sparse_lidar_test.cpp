#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "drivers/measurement/angles.hpp"
#include "drivers/robosense/robosense_maker.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"
#include "fixtures/simulator/simulation.hpp"
#include "fusion/registration/lidar_trajectory.hpp"
#include "tests/folders.hpp"

namespace infuse::study {
namespace {

/// A VLP-16, mounted askew, on a vehicle that drives through an invented town.
simulator::Scenario sparse_lidar(double start_speed, double speed) {
  simulator::Scenario s;
  s.seed = 9006;
  s.world_seed = 706;
  s.duration = 20;
  s.town = {.size = 1000, .block = 130, .built_up = 0.59};
  s.route_length = 900;
  s.street.trees = 0.67;
  s.street.build_radius = 80;
  s.street.ground_resolution = 1;
  s.motion.start_speed = start_speed;
  s.motion.speed = speed;
  simulator::LidarOptions lidar;
  lidar.model = &velodyne::lidar_model(velodyne::Model::kVlp16);
  lidar.rays_per_pulse = 1;
  lidar.T_vehicle_lidar.translation() = Eigen::Vector3d(0.14, -0.27, 2.49);
  lidar.T_vehicle_lidar.linear() = (Eigen::AngleAxisd(-68 * kDegree, Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(6.9 * kDegree, Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(2.9 * kDegree, Eigen::Vector3d::UnitX()))
                                       .toRotationMatrix();
  s.lidars.push_back(lidar);
  return s;
}

struct Followed {
  int claimed = 0;       // sweeps whose motion is usable, with the way determined
  double max_error = 0;  // m along the way, of these
  double way = 0, true_way = 0;
};

Followed follow(const simulator::Scenario& scenario, uint64_t turns) {
  auto simulation = simulator::Simulation::create(scenario);
  EXPECT_TRUE(simulation.has_value());
  const simulator::Lidar& lidar = simulation->lidars().front();
  registration::LidarTrajectory trajectory(lidar.options().T_vehicle_lidar);
  Followed out;
  for (uint64_t turn = 0; turn < turns; ++turn) {
    const Sweep sweep = lidar.to_sweep(simulation->scan_turn(0, turn), Stamp());
    const registration::LidarOdometryResult& found = trajectory.add(sweep);
    if (!found.usable()) continue;
    const auto pose = [&](Stamp stamp) { return simulation->pose()(to_seconds(stamp - Stamp())); };
    const Eigen::Isometry3d truth = pose(found.motion.from).inverse() * pose(found.motion.to);
    out.way += found.motion.T_from_to.translation().norm();
    out.true_way += truth.translation().norm();
    // Directions that are free have no information.
    const geometry::Matrix6 covariance =
        (found.motion.information + 1e-6 * geometry::Matrix6::Identity()).inverse();
    if (std::sqrt(covariance(3, 3)) > 0.1) continue;
    ++out.claimed;
    const Eigen::Vector3d error = found.motion.T_from_to.translation() - truth.translation();
    out.max_error = std::max(out.max_error, std::abs(error.x()));
  }
  return out;
}

// The rings lie where they lay before, in the vehicle's frame: their returns must not hold it back.
TEST(SparseLidar, ClaimsNoWrongSpeedFromRest) {
  const Followed found = follow(sparse_lidar(0, 13), 60);
  EXPECT_GE(found.claimed, 40);
  EXPECT_LT(found.max_error, 0.05);
  EXPECT_NEAR(found.way, found.true_way, 0.02 * found.true_way);
}

// Where the lidar does not show the speed, all that are tried at the start fit about as well.
TEST(SparseLidar, TakesAStartThatNothingShowsAsSlow) {
  simulator::Scenario scenario = sparse_lidar(0, 13);
  scenario.town = {.size = 400, .block = 130, .built_up = 0.6};
  scenario.route_length = 250;
  scenario.street.trees = 0.7;
  Eigen::Isometry3d& mount = scenario.lidars.front().T_vehicle_lidar;
  mount.translation() = Eigen::Vector3d(0.1, -0.3, 2.5);
  mount.linear() = Eigen::AngleAxisd(7 * kDegree, Eigen::Vector3d::UnitY()).toRotationMatrix();
  const Followed found = follow(scenario, 5);
  EXPECT_LT(found.true_way, 0.2);
  EXPECT_LT(found.way, 0.5);
}

// The rings of a lidar that looks down stand still around it, and walls along the street fit any
// speed: neither may outweigh what shows the speed.
TEST(SparseLidar, StartsAtSpeedThoughItLooksDown) {
  simulator::Scenario scenario;
  scenario.seed = 11;
  scenario.duration = 20;
  scenario.map = source_folder() + "/fixtures/maps/altfeld.osm";
  scenario.route = {100, 104, 112, 110, 115, 117, 119, 107};
  scenario.motion.start_speed = scenario.motion.speed = 9;
  simulator::LidarOptions lidar;
  lidar.model = &robosense::lidar_model(robosense::Model::kHelios);
  lidar.rays_per_pulse = 1;
  lidar.T_vehicle_lidar.translation() = Eigen::Vector3d(1, 0, 1.95);
  scenario.lidars.push_back(lidar);
  const Followed found = follow(scenario, 2);
  EXPECT_EQ(found.claimed, 1);
  EXPECT_LT(found.max_error, 0.05);
}

// Fog is always around the lidar, and would hold it back as well.
TEST(SparseLidar, ClaimsNoWrongSpeedInFog) {
  simulator::Scenario scenario = sparse_lidar(15, 15);
  scenario.air.fog_visibility = 40;
  const Followed found = follow(scenario, 60);
  EXPECT_GE(found.claimed, 40);
  EXPECT_LT(found.max_error, 0.05);
  EXPECT_NEAR(found.way, found.true_way, 0.01 * found.true_way);
}

}  // namespace
}  // namespace infuse::study
