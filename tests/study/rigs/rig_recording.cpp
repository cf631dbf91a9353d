#include "tests/study/rigs/rig_recording.hpp"

#include <cmath>
#include <utility>

#include "fixtures/simulator/random_scenario.hpp"
#include "fixtures/simulator/simulation.hpp"

namespace infuse::study {
namespace {

constexpr double kTwistStep = 0.01;     // s each side of the exposure
constexpr int64_t kPoseStep = 500'000;  // ns; returns of one step share a pose

/// Moves every return to where it would have been measured at `time`.
void deskew(Sweep& sweep, const simulator::Simulation& simulation, double time) {
  const Eigen::Isometry3d& mount = simulation.lidars()[0].options().T_vehicle_lidar;
  const auto T_map_lidar = [&](double at) { return simulation.pose()(at) * mount; };
  const Eigen::Isometry3d T_now_map = T_map_lidar(time).inverse();
  Eigen::Isometry3f moved = Eigen::Isometry3f::Identity();
  int64_t step = -1;
  for (size_t i = 0; i < sweep.size(); ++i) {
    const int64_t offset =
        (sweep.stamp - simulation.scenario().start).count() + sweep.time_offset_ns[i];
    if (offset / kPoseStep != step) {
      step = offset / kPoseStep;
      const double at = 1e-9 * static_cast<double>(step * kPoseStep + kPoseStep / 2);
      moved = (T_now_map * T_map_lidar(at)).cast<float>();
    }
    const Eigen::Vector3f p = moved * Eigen::Vector3f(sweep.x[i], sweep.y[i], sweep.z[i]);
    sweep.x[i] = p.x();
    sweep.y[i] = p.y();
    sweep.z[i] = p.z();
  }
}

RigScene render(simulator::Simulation& simulation, uint64_t turn) {
  const simulator::Lidar& lidar = simulation.lidars()[0];
  const double time = (static_cast<double>(turn) + 0.5) / lidar.options().rate;
  RigScene scene;
  scene.frame = simulation.render_image(0, time, turn);
  scene.sweep = lidar.to_sweep(simulation.scan_turn(0, turn), simulation.scenario().start);
  deskew(scene.sweep, simulation, time);
  const Eigen::Isometry3d& mount = lidar.options().T_vehicle_lidar;
  const Eigen::Isometry3d before = simulation.pose()(time - kTwistStep) * mount;
  const Eigen::Isometry3d after = simulation.pose()(time + kTwistStep) * mount;
  scene.twist = geometry::log(before.inverse() * after) / (2 * kTwistStep);
  return scene;
}

}  // namespace

Result<RigRecording> record_random_rig(uint64_t seed, const RigRecordingOptions& options) {
  simulator::Scenario scenario = simulator::draw_scenario({.duration = options.duration}, seed);
  if (options.world) {
    simulator::Scenario other =
        simulator::draw_scenario({.duration = options.duration}, *options.world);
    other.lidars = std::move(scenario.lidars);
    other.cameras = std::move(scenario.cameras);
    scenario = std::move(other);
  }
  scenario.cameras[0].options.grey = true;
  scenario.cameras[0].options.contact_shadows = false;
  auto simulation = simulator::Simulation::create(scenario, 1);
  if (!simulation) return tl::unexpected(simulation.error());
  RigRecording out{.camera = scenario.cameras[0].options.intrinsics};
  out.T_camera_lidar =
      scenario.cameras[0].options.T_vehicle_camera.inverse() * scenario.lidars[0].T_vehicle_lidar;
  out.lidar = simulation->lidars()[0].options().model->name;
  const double rate = scenario.lidars[0].rate;
  const double usable = std::min(options.duration, simulation->duration()) - 2 / rate;
  for (int k = 0; k < options.diverse; ++k) {
    const double time = 1 + (usable - 1) * k / options.diverse;
    out.diverse.push_back(render(*simulation, static_cast<uint64_t>(time * rate)));
  }
  for (int k = 0; k < options.neighbours; ++k) {
    const double time = usable / 2;
    out.neighbours.push_back(
        render(*simulation, static_cast<uint64_t>(time * rate) + static_cast<uint64_t>(k)));
  }
  return out;
}

}  // namespace infuse::study
