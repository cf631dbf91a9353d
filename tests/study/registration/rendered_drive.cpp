#include "tests/study/registration/rendered_drive.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"

#include <cmath>
#include <numbers>

#include "fixtures/simulator/world/random.hpp"

namespace infuse::study {
namespace {

constexpr double kRoute = 300;  // m

/// Camera `index` of a ring of five, after the vehicle of P's experiments.
simulator::ScenarioCamera ring_camera(int index) {
  constexpr double kRadius = 0.06;  // m
  simulator::ScenarioCamera camera;
  auto& options = camera.options;
  options.name = "cam" + std::to_string(index);
  options.grey = true;
  auto& k = options.intrinsics;
  k.width = 640;
  k.height = 480;
  k.fx = k.fy = 336;
  k.cx = 319.5;
  k.cy = 239.5;
  k.distortion = {-0.2, 0.04, 0, 0, 0};
  const double yaw = 2 * std::numbers::pi * index / 5;
  Eigen::Matrix3d forward;  // camera axes of a camera that faces along x
  forward << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  options.T_vehicle_camera.linear() =
      Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix() * forward;
  options.T_vehicle_camera.translation() =
      Eigen::Vector3d(1.0 + kRadius * std::cos(yaw), kRadius * std::sin(yaw), 2.1 - 0.25);
  return camera;
}

simulator::Scenario draw_scenario(uint64_t seed) {
  const simulator::Random random(seed, "scenario");
  simulator::Scenario s;
  s.seed = seed;
  s.town.size = 450;
  s.town.block = random.uniform(8, 80, 140);
  s.town.built_up = random.uniform(9, 0.6, 1);
  s.route_length = kRoute;
  s.light.sun = random.uniform(0) < 0.3 ? 0 : random.uniform(1, 0.3, 1);
  s.light.sun_elevation = random.uniform(2, 0.2, 1.0);
  s.light.sun_azimuth = random.uniform(3, -std::numbers::pi, std::numbers::pi);
  s.light.brightness = random.uniform(4, 0.3, 1);
  s.street.trees = random.uniform(5, 0.3, 1);
  s.street.parked_cars = random.uniform(6, 0.2, 0.8);
  s.street.build_radius = 80;
  s.motion.speed = s.motion.start_speed = random.uniform(7, 6, 11);
  s.duration = 60;
  simulator::LidarOptions lidar;
  lidar.model = &velodyne::lidar_model(velodyne::Model::kHdl64eS2);
  lidar.T_vehicle_lidar.translation() = Eigen::Vector3d(1.0, 0, 2.1);
  s.lidars.push_back(lidar);
  for (int i = 0; i < 5; ++i) s.cameras.push_back(ring_camera(i));
  return s;
}

}  // namespace

simulator::LidarOptions roof_lidar(velodyne::Model model, double height) {
  simulator::LidarOptions lidar;
  lidar.model = &velodyne::lidar_model(model);
  lidar.rays_per_pulse = 1;
  lidar.T_vehicle_lidar.translation() = Eigen::Vector3d(1.0, 0, height);
  return lidar;
}

Sweep deskewed_turn(simulator::Simulation& simulation, double time) {
  const simulator::Lidar& lidar = simulation.lidars().front();
  const double half = 0.5 / lidar.options().rate;
  const simulator::LidarBlock block = simulation.scan(0, time - half, time + half);
  const Eigen::Isometry3d& T_vehicle_lidar = lidar.options().T_vehicle_lidar;
  const simulator::PoseFunction pose = simulation.pose();
  const Eigen::Isometry3d T_lidar_map = (pose(time) * T_vehicle_lidar).inverse();
  Sweep sweep;
  sweep.rings = static_cast<uint16_t>(block.slots);
  sweep.columns = static_cast<uint32_t>(block.sequences);
  sweep.stamp = simulation.scenario().start + from_seconds(time);
  sweep.reserve(block.strongest.size());
  for (size_t i = 0; i < block.sequences; ++i) {
    const double fired = lidar.firing_time(block.first_sequence + i, 0);
    const Eigen::Vector3d origin = (pose(fired) * T_vehicle_lidar).translation();
    for (size_t slot = 0; slot < block.slots; ++slot) {
      const simulator::LidarReturn& r = block.strongest[i * block.slots + slot];
      if (r.range <= 0) continue;
      const Eigen::Vector3d seen =
          origin + (r.point.cast<double>() - origin) * (r.range / r.true_range);
      const Eigen::Vector3f p = (T_lidar_map * seen).cast<float>();
      sweep.x.push_back(p.x());
      sweep.y.push_back(p.y());
      sweep.z.push_back(p.z());
      sweep.range.push_back(r.range);
      sweep.reflectivity.push_back(static_cast<float>(r.reflectivity) / 255);
      sweep.ring.push_back(lidar.pattern().slots[slot].ring);
      sweep.column.push_back(static_cast<uint16_t>(i));
      sweep.time_offset_ns.push_back(0);
      sweep.return_kind.push_back(ReturnKind::kStrongest);
    }
  }
  return sweep;
}

double time_of(const simulator::Simulation& simulation, double distance) {
  double low = 0, high = simulation.duration();
  for (int i = 0; i < 50; ++i) {
    const double middle = (low + high) / 2;
    (simulation.motion().distance_driven(middle) < distance ? low : high) = middle;
  }
  return high;
}

Result<RenderedDrive> render_drive(uint64_t seed, const std::vector<double>& distances,
                                   const RenderOptions& options) {
  auto simulation = simulator::Simulation::create(draw_scenario(seed), options.threads);
  if (!simulation) return tl::unexpected(simulation.error());
  // Anywhere along the route, away from its ends.
  const double last = distances.empty() ? 0 : distances.back();
  const double start = simulator::Random(seed, "start").uniform(0, 20, kRoute - 40 - last);
  RenderedDrive drive;
  drive.rig = simulation->true_rig(0);
  for (const double distance : distances) {
    const double time = time_of(*simulation, start + distance);
    PosedScan& scan = drive.scans.emplace_back();
    scan.sweep = deskewed_turn(*simulation, time);
    const size_t cameras = options.images ? simulation->cameras().size() : 0;
    for (size_t camera = 0; camera < cameras; ++camera) {
      scan.images.push_back(simulation->render_image(camera, time, drive.scans.size()));
    }
    scan.T_world_lidar = simulation->pose()(time) * drive.rig.lidars.front().T_vehicle_lidar;
  }
  return drive;
}

}  // namespace infuse::study
