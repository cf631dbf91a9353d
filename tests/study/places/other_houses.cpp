#include "tests/study/places/other_houses.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <ostream>
#include <sstream>
#include <stdexcept>

#include "drivers/measurement/median.hpp"
#include "fixtures/simulator/simulation.hpp"
#include "fusion/features/air_returns.hpp"
#include "fusion/places/localiser.hpp"
#include "tests/study/registration/rendered_drive.hpp"

namespace infuse::study {
namespace {

const std::vector<int64_t> kHousesMapRoute{115, 116, 117, 118, 119, 124, 107};
const std::vector<int64_t> kHousesVisitRoute{116, 117, 118, 119, 124};
constexpr uint64_t kOtherHouses = 100'000;  // added to the seed of a town
constexpr double kSweepSpacing = 1, kTrialSpacing = 30, kMaxSearch = 60;  // m
constexpr double kTrackedOn = 20;                                         // m after it was found
constexpr double kEnds = 5;                                               // m, left out
constexpr double kWrongPlace = 1;                                         // m
// Of the true motion, stated: as good as wheels and a lidar.
constexpr double kMotionRotation = 3e-4, kMotionTranslation = 5e-3;  // rad, m

struct StreetVisit {
  uint64_t world = 0, seed = 0;
  simulator::Season season = simulator::Season::kSummer;
  int building_sites = 0;
  double parked_cars = 0.5;
  std::vector<int64_t> route;
};

simulator::Simulation simulate(const std::string& map, const StreetVisit& visit) {
  simulator::Scenario s;
  s.seed = visit.seed;
  s.world_seed = visit.world;
  s.map = map;
  s.route = visit.route;
  s.built_along = kHousesMapRoute;
  s.street.build_radius = 80;
  s.street.season.season = visit.season;
  s.street.season.building_sites = visit.building_sites;
  s.street.parked_cars = visit.parked_cars;
  s.motion.speed = s.motion.start_speed = 8;
  s.duration = 120;
  s.lidars.push_back(roof_lidar(velodyne::Model::kVlp16, 1.95));
  auto simulation = simulator::Simulation::create(s);
  if (!simulation) throw std::runtime_error(simulation.error().message());
  return *std::move(simulation);
}

/// Distance driven up to the last sweep.
double end_of(const simulator::Simulation& simulation) {
  return simulation.motion().distance_driven(simulation.duration()) - kEnds;
}

/// Calls `on_sweep(points, reflectivity, motion, T_map_vehicle)` along a drive.
template <class OnSweep>
void drive_along(simulator::Simulation& simulation, OnSweep on_sweep) {
  const simulator::PoseFunction pose = simulation.pose();
  const double end = end_of(simulation);
  features::AirReturns air;
  Eigen::Isometry3d before = pose(time_of(simulation, kEnds));
  for (double distance = kEnds; distance < end; distance += kSweepSpacing) {
    const double time = time_of(simulation, distance);
    const Sweep sweep = deskewed_turn(simulation, time);
    mapping::SweepMotion motion{.stamp = sweep.stamp, .T_from_to = before.inverse() * pose(time)};
    motion.covariance.diagonal().head<3>().setConstant(kMotionRotation * kMotionRotation);
    motion.covariance.diagonal().tail<3>().setConstant(kMotionTranslation * kMotionTranslation);
    motion.registered = motion.measured = true;
    before = pose(time);
    air.find(sweep);
    on_sweep(geometry::PointsView{air.without(sweep.x), sweep.y, sweep.z}, sweep.reflectivity,
             motion, before);
  }
}

places::PlaceMap map_town(const std::string& map, uint64_t seed, Eigen::Isometry3d& T_lidar) {
  auto simulation = simulate(map, {.world = seed, .seed = seed + 1, .route = kHousesMapRoute});
  T_lidar = simulation.lidars().front().options().T_vehicle_lidar;
  places::PlaceMap out;
  out.T_vehicle_lidar = T_lidar;
  mapping::KeyframeSubmaps submaps({}, {}, T_lidar);
  std::vector<mapping::Submap> clouds;
  std::optional<Eigen::Isometry3d> T_map_odom;
  drive_along(simulation, [&](const auto& points, const auto& reflectivity, const auto& motion,
                              const Eigen::Isometry3d& truth) {
    const auto ended = submaps.add(points, reflectivity, motion);
    if (!T_map_odom) T_map_odom = truth;  // odometry begins at the identity
    if (!ended) return;
    out.T_map_vehicle.push_back(*T_map_odom * ended->keyframe.T_odom_vehicle);
    out.descriptors.push_back(places::describe_place(ended->submap.points(), T_lidar));
    clouds.push_back(ended->submap);
  });
  out.read_cloud = [clouds = std::move(clouds)](size_t k) -> Result<mapping::Submap> {
    return clouds[k];
  };
  return out;
}

struct OpenTrial {
  places::Localiser localiser;
  HousesTrial trial;
};

std::vector<HousesTrial> try_visit(const places::PlaceMap& map, simulator::Simulation simulation,
                                   const HousesTrial& as) {
  std::vector<std::unique_ptr<OpenTrial>> trials;
  const Eigen::Isometry3d T_lidar = simulation.lidars().front().options().T_vehicle_lidar;
  // Each has room to be found or given up: near the end of the visit only what is found would
  // count.
  const double last_start = end_of(simulation) - kEnds - kMaxSearch - kTrackedOn;
  double distance = -kSweepSpacing;
  drive_along(simulation, [&](const auto& points, const auto& reflectivity, const auto& motion,
                              const Eigen::Isometry3d& truth) {
    distance += kSweepSpacing;
    const double next_start = static_cast<double>(trials.size()) * kTrialSpacing;
    if (distance >= next_start && next_start < last_start) {
      trials.push_back(std::make_unique<OpenTrial>(OpenTrial{places::Localiser(map, T_lidar), as}));
      trials.back()->trial.start = distance;
    }
    for (const auto& open : trials) {
      HousesTrial& t = open->trial;
      const double driven = distance - t.start;
      if (driven > (t.found < 0 ? kMaxSearch : t.found + kTrackedOn)) continue;
      const auto pose = open->localiser.add(points, reflectivity, motion);
      if (!pose) throw std::runtime_error(pose.error().message());
      if (!pose->usable()) continue;
      if (t.found < 0) t.found = driven;
      const Eigen::Vector3d error = pose->T_map_vehicle.translation() - truth.translation();
      t.error = std::max(t.error, std::hypot(error.x(), error.y()));
    }
  });
  std::vector<HousesTrial> out;
  for (const auto& open : trials) out.push_back(open->trial);
  return out;
}

/// Median and maximum of what was found, in a table.
std::string middle_and_most(std::vector<double> values, int decimals) {
  if (values.empty()) return "– | –";
  const double most = *std::max_element(values.begin(), values.end());
  return fmt::format("{:.{}f} m | {:.{}f} m", nth_smallest(values, (values.size() - 1) / 2),
                     decimals, most, decimals);
}

}  // namespace

std::vector<HousesTrial> read_houses_trials(std::istream& in) {
  std::vector<HousesTrial> out;
  for (std::string line; std::getline(in, line);) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream row(line);
    HousesTrial t;
    if (row >> t.seed >> t.other_houses >> t.start >> t.found >> t.error) out.push_back(t);
  }
  return out;
}

void write_houses_header(std::ostream& out) { out << "seed,other_houses,start,found,error\n"; }

void write_houses_trial(std::ostream& out, const HousesTrial& t) {
  out << t.seed << ',' << t.other_houses << ',' << t.start << ',' << t.found << ',' << t.error
      << '\n';
}

std::vector<HousesTrial> try_other_houses(const std::string& map, uint64_t seed) {
  Eigen::Isometry3d T_lidar;
  const places::PlaceMap mapped = map_town(map, seed, T_lidar);
  std::vector<int64_t> route = kHousesVisitRoute;
  if (seed % 2 == 1) std::reverse(route.begin(), route.end());
  StreetVisit visit{.world = seed,
                    .seed = seed + 2,
                    .season = simulator::Season::kAutumn,
                    .building_sites = 2,
                    .parked_cars = 0.4,
                    .route = route};
  std::vector<HousesTrial> out =
      try_visit(mapped, simulate(map, visit), {.seed = seed, .other_houses = false});
  visit.world = seed + kOtherHouses;
  visit.building_sites = 0;
  const auto others = try_visit(mapped, simulate(map, visit), {.seed = seed, .other_houses = true});
  out.insert(out.end(), others.begin(), others.end());
  return out;
}

void write_houses_table(std::ostream& out, const std::vector<HousesTrial>& trials) {
  out << "| visit | towns | trials | TRACKING | wrong by more than 1 m | m until TRACKING, median "
         "| "
         "maximum | error, median | maximum |\n|---|---|---|---|---|---|---|---|---|\n";
  for (const bool other : {false, true}) {
    std::vector<double> metres, errors;
    std::vector<uint64_t> towns;
    size_t count = 0, wrong = 0;
    for (const HousesTrial& t : trials) {
      if (t.other_houses != other) continue;
      ++count;
      towns.push_back(t.seed);
      if (t.found < 0) continue;
      metres.push_back(t.found);
      errors.push_back(t.error);
      wrong += t.error > kWrongPlace ? 1 : 0;
    }
    std::sort(towns.begin(), towns.end());
    const auto different = std::unique(towns.begin(), towns.end()) - towns.begin();
    out << fmt::format("| {} | {} | {} | {} | {} | {} | {} |\n",
                       other ? "the same streets, other houses" : "the same town in autumn",
                       different, count, metres.size(), wrong, middle_and_most(metres, 0),
                       middle_and_most(errors, 2));
  }
}

}  // namespace infuse::study
