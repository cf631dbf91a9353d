#include "tests/study/places/upright.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <ostream>
#include <sstream>
#include <stdexcept>

#include "daemon/mapping/map_finish.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "daemon/tools/map/map_drive.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/measurement/median.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "fixtures/simulator/drive_writer.hpp"
#include "fusion/motion/trajectory_error.hpp"
#include "tests/scratch_folder.hpp"
#include "tests/study/registration/rendered_drive.hpp"

namespace infuse::study {
namespace {

constexpr std::array<const char*, 3> kShapes{"along a street", "with turns",
                                             "with turns, hills of 3 %"};
constexpr double kAllowed = 0.5 * kDegree;
constexpr double kQuantile = 3.03;  // 99 % of χ² with 2 degrees of freedom is 9.21

simulator::Scenario draw(const std::string& map, const UprightTrial& trial) {
  simulator::Scenario s;
  s.seed = trial.seed;
  s.map = map;
  s.route = trial.shape == 0 ? std::vector<int64_t>{115, 116, 117, 118, 119}
                             : std::vector<int64_t>{117, 122, 104, 105, 106, 107, 124, 119};
  if (trial.seed % 2 == 1) std::reverse(s.route.begin(), s.route.end());
  s.street.build_radius = 70;
  s.street.grade = trial.shape == 2 ? 0.03 : 0;
  s.motion.speed = s.motion.start_speed = 9;
  s.duration = 20;
  if (!trial.imu) s.vehicle.imu_rate = 0;
  s.lidars.push_back(roof_lidar(velodyne::Model::kVlp16, 1.95));
  return s;
}

template <class Value>
Value required(Result<Value> result) {
  if (!result) throw std::runtime_error(result.error().message());
  return *std::move(result);
}

std::vector<geometry::StampedPose> poses_of(const std::filesystem::path& file) {
  std::vector<geometry::StampedPose> out;
  for (const auto& pose : required(recording::read_trajectory(file)))
    out.push_back({pose.stamp, pose.T_frame_body});
  return out;
}

}  // namespace

std::vector<UprightTrial> read_upright_trials(std::istream& in) {
  std::vector<UprightTrial> out;
  for (std::string line; std::getline(in, line);) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream row(line);
    UprightTrial t;
    if (row >> t.seed >> t.shape >> t.gnss >> t.imu >> t.tilt >> t.sigma) out.push_back(t);
  }
  return out;
}

void write_upright_header(std::ostream& out) { out << "seed,shape,gnss,imu,tilt,sigma\n"; }

void write_upright_trial(std::ostream& out, const UprightTrial& t) {
  out << t.seed << ',' << t.shape << ',' << t.gnss << ',' << t.imu << ',' << t.tilt << ','
      << t.sigma << '\n';
}

std::vector<UprightTrial> try_upright(const std::string& map, uint64_t seed) {
  UprightTrial trial{.seed = seed,
                     .shape = static_cast<int>(seed % 3),
                     .gnss = seed / 3 % 2 == 0,
                     .imu = seed / 6 % 2 == 0};
  const ScratchFolder folder;
  auto simulation = required(simulator::Simulation::create(draw(map, trial)));
  required(simulator::write_drive(simulation, folder / "drive", [](double) {}));
  auto setup = required(daemon::open_drive(folder / "drive", {}, {}));
  daemon::MapSettings settings;
  settings.use_gnss = trial.gnss;
  const daemon::MapFolder made((folder / "map").string());
  if (const auto replayed = daemon::replay_to_map(made, setup, 0, settings); !replayed)
    throw std::runtime_error(replayed.error().message());
  const auto summary =
      required(daemon::finish_map(made, required(daemon::read_map_drive(made)), settings, {}));
  if (!summary.usable()) return {};
  trial.sigma = summary.tilt_sigma;
  for (const motion::PosePair& pose : motion::pair_by_time(
           poses_of(folder / "map/trajectory.tum"), poses_of(folder / "drive/truth/poses.tum"))) {
    // Where up is, as the vehicle sees it.
    const Eigen::Vector3d stated = pose.estimate.linear().row(2),
                          truth = pose.truth.linear().row(2);
    trial.tilt = std::max(trial.tilt, std::atan2(stated.cross(truth).norm(), stated.dot(truth)));
  }
  return {trial};
}

void write_upright_table(std::ostream& out, const std::vector<UprightTrial>& trials) {
  out << "| drives | number | tilt, median | maximum | stated sigma, median | at most 0.5° | at "
         "most 0.5° or covered |\n|---|---|---|---|---|---|---|\n";
  const auto row = [&](const std::string& name, auto belongs) {
    std::vector<double> tilts, sigmas;
    size_t upright = 0, covered = 0;
    for (const UprightTrial& t : trials) {
      if (!belongs(t)) continue;
      tilts.push_back(t.tilt / kDegree);
      sigmas.push_back(t.sigma / kDegree);
      upright += t.tilt <= kAllowed ? 1 : 0;
      covered += t.tilt <= std::max(kAllowed, kQuantile * t.sigma) ? 1 : 0;
    }
    if (tilts.empty()) return;
    const double largest = *std::max_element(tilts.begin(), tilts.end());
    const size_t middle = (tilts.size() - 1) / 2;
    out << fmt::format("| {} | {} | {:.2f}° | {:.2f}° | {:.2f}° | {} | {} |\n", name, tilts.size(),
                       nth_smallest(tilts, middle), largest, nth_smallest(sigmas, middle), upright,
                       covered);
  };
  for (int shape = 0; shape < 3; ++shape) {
    row(kShapes[static_cast<size_t>(shape)],
        [&](const UprightTrial& t) { return t.shape == shape; });
  }
  row("with GNSS", [](const UprightTrial& t) { return t.gnss; });
  row("without GNSS", [](const UprightTrial& t) { return !t.gnss; });
  row("with an inertial unit", [](const UprightTrial& t) { return t.imu; });
  row("without an inertial unit", [](const UprightTrial& t) { return !t.imu; });
  row("all", [](const UprightTrial&) { return true; });
}

}  // namespace infuse::study
