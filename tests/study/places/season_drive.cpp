#include "tests/study/places/season_drive.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/study/registration/rendered_drive.hpp"

namespace infuse::study {
namespace {

using simulator::Season;

simulator::ScenarioCamera place_camera(int index) {
  constexpr double kRadius = 0.06;  // m
  simulator::ScenarioCamera camera;
  auto& options = camera.options;
  options.name = "cam" + std::to_string(index);
  options.grey = true;
  options.samples = 1;
  auto& k = options.intrinsics;
  k.width = 240;
  k.height = 180;
  k.fx = k.fy = 135;
  k.cx = 119.5;
  k.cy = 89.5;
  const double yaw = 2 * std::numbers::pi * index / 5;
  Eigen::Matrix3d forward;  // camera axes of a camera that faces along x
  forward << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  options.T_vehicle_camera.linear() =
      Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix() * forward;
  options.T_vehicle_camera.translation() =
      Eigen::Vector3d(1.0 + kRadius * std::cos(yaw), kRadius * std::sin(yaw), 1.85);
  return camera;
}

}  // namespace

const std::vector<Visit>& season_visits() {
  static const std::vector<Visit> kVisits{
      {"winter", {.season = Season::kWinter}, {}, {.sun = 0, .brightness = 0.4}, 0.5, 901, false},
      {"winter again",
       {.season = Season::kWinter},
       {},
       {.sun = 0, .brightness = 0.4},
       0.45,
       906,
       false},
      {"summer",
       {.season = Season::kSummer},
       {},
       {.sun = 1, .sun_elevation = 0.9, .sun_azimuth = 0.8, .brightness = 1},
       0.4,
       902,
       true},
      {"autumn, rain",
       {.season = Season::kAutumn, .wet = 0.9, .building_sites = 4},
       {.rain = 8},
       {.sun = 0.1, .sun_elevation = 0.4, .sun_azimuth = -1, .brightness = 0.3},
       0.6,
       903,
       false},
      {"snow",
       {.season = Season::kWinter, .snow = 0.85, .building_sites = 3},
       {.fog_visibility = 400},
       {.sun = 0.6, .sun_elevation = 0.25, .sun_azimuth = 2.2, .brightness = 0.8},
       0.35,
       904,
       false},
      {"night",
       {.season = Season::kSummer, .wet = 0.4, .building_sites = 2},
       {},
       {.sun = 0, .brightness = 0.003, .street_lamps = true},
       0.75,
       905,
       true},
  };
  return kVisits;
}

Result<SeasonDrive> render_visit(const std::string& map, uint64_t world_seed, const Visit& visit,
                                 std::vector<int64_t> route,
                                 const std::vector<int64_t>& built_along, double spacing) {
  if (visit.reversed) std::reverse(route.begin(), route.end());
  simulator::Scenario s;
  s.seed = visit.seed;
  s.world_seed = world_seed;
  s.map = map;
  s.route = std::move(route);
  s.built_along = built_along;
  s.street.build_radius = 80;
  s.street.season = visit.season;
  s.street.parked_cars = visit.parked_cars;
  s.air = visit.air;
  s.light = visit.light;
  s.motion.speed = s.motion.start_speed = 8;
  s.duration = 200;
  s.lidars.push_back(roof_lidar(velodyne::Model::kHdl64eS2, 2.1));
  for (int i = 0; i < 5; ++i) s.cameras.push_back(place_camera(i));
  auto simulation = simulator::Simulation::create(s);
  if (!simulation) return tl::unexpected(simulation.error());
  SeasonDrive drive;
  drive.rig = simulation->true_rig(0);
  const double end = simulation->motion().distance_driven(simulation->duration()) - 5;
  for (double way = 5; way < end; way += spacing) {
    const double time = time_of(*simulation, way);
    SeasonScan& out = drive.scans.emplace_back();
    out.scan.sweep = deskewed_turn(*simulation, time);
    for (size_t camera = 0; camera < s.cameras.size(); ++camera)
      out.scan.images.push_back(simulation->render_image(camera, time, drive.scans.size()));
    out.T_map_vehicle = simulation->pose()(time);
    out.scan.T_world_lidar = out.T_map_vehicle * drive.rig.lidars.front().T_vehicle_lidar;
  }
  return drive;
}

}  // namespace infuse::study
