// Lidar odometry on KITTI raw 0009 as imported (INFUSE_REAL_DATA), with and without the usual
// correction of the vertical angles, and on a simulated drive of 3.7 km, through an invented town
// and, where the recorded route is, along that of KITTI 00. KISS-ICP, where its sources are
// (INFUSE_PEERS), has the same sweeps with the same times of their returns, its default settings
// and one thread; its poses, of the last return of a sweep, are moved to the middle. On 0009 it
// runs without its deskewing too. The drives with wheels and with an inertial unit are replayed by
// infused.
//
// `step_mm` is the median error of the motion between two sweeps, `along_m`, `across_m` and
// `height_m` are errors at the end, `kitti_percent` is KITTI's score over 100 … 800 m,
// `kitti_deg_per_100m` the same of the rotation.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "daemon/playback/play_lidar.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/measurement/median.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/recording/drive_toml.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "drivers/text/text_file.hpp"
#include "fusion/motion/trajectory_error.hpp"
#include "fusion/registration/lidar_trajectory.hpp"
#include "tests/bench/rendered_drive.hpp"
#include "tests/folders.hpp"
#include "tests/real_kitti.hpp"
#ifdef INFUSE_PEER_KISS_ICP
#include "tests/bench/peer_kiss_icp.hpp"
#endif

namespace infuse {
namespace {

using geometry::StampedPose;
using Poses = std::vector<StampedPose>;

Stamp middle(const Sweep& sweep) { return sweep.stamp + sweep.span / 2; }

/// Our odometry: poses of the vehicle at the middles of the sweeps.
class Ours {
 public:
  explicit Ours(const Eigen::Isometry3d& T_vehicle_lidar) : trajectory_(T_vehicle_lidar) {}

  void prepare(const Sweep&) {}
  void add(const Sweep& sweep) {
    const registration::LidarOdometryResult& result = trajectory_.add(sweep);
    if (!result.usable()) return;
    if (poses_.empty()) {
      poses_.push_back(
          {result.motion.from, result.T_map_vehicle * result.motion.T_from_to.inverse()});
    }
    poses_.push_back({result.stamp, result.T_map_vehicle});
  }
  Poses poses() const { return poses_; }

 private:
  registration::LidarTrajectory trajectory_;
  Poses poses_;
};

#ifdef INFUSE_PEER_KISS_ICP
/// KISS-ICP; poses as ours. Its own deskewing, with the motion before, can be left out.
template <bool kDeskew>
class KissIcp {
 public:
  explicit KissIcp(const Eigen::Isometry3d& T_vehicle_lidar) : T_vehicle_lidar_(T_vehicle_lidar) {}

  void prepare(const Sweep& sweep) {
    const auto& times = sweep.time_offset_ns;
    peer_.set_points(sweep.x.data(), sweep.y.data(), sweep.z.data(), times.data(), sweep.size());
    middles_.push_back(middle(sweep));
    ends_.push_back({sweep.stamp + Duration(*std::max_element(times.begin(), times.end())), {}});
  }
  void add(const Sweep&) {
    Eigen::Matrix4d T_first_lidar;
    peer_.add(T_first_lidar.data());
    Eigen::Isometry3d T(T_first_lidar);
    ends_.back().T_odom_vehicle = T_vehicle_lidar_ * T * T_vehicle_lidar_.inverse();
  }
  /// Between the ends of its sweep and the one before; the first in the motion that follows.
  Poses poses() const {
    Poses poses;
    if (!kDeskew) {
      for (size_t k = 0; k < ends_.size(); ++k) {
        poses.push_back({middles_[k], ends_[k].T_odom_vehicle});
      }
      return poses;
    }
    for (size_t k = 0; k < ends_.size() && ends_.size() > 1; ++k) {
      const StampedPose &from = ends_[k == 0 ? 0 : k - 1], &to = ends_[k == 0 ? 1 : k];
      const double share = to_seconds(middles_[k] - from.stamp) / to_seconds(to.stamp - from.stamp);
      poses.push_back(
          {middles_[k],
           from.T_odom_vehicle * geometry::exp(share * geometry::log(from.T_odom_vehicle.inverse() *
                                                                     to.T_odom_vehicle))});
    }
    return poses;
  }

 private:
  Eigen::Isometry3d T_vehicle_lidar_;
  bench::PeerKissIcp peer_{kDeskew};
  std::vector<Stamp> middles_;
  Poses ends_;
};
#endif

/// Errors of a trajectory into the counters.
void score(benchmark::State& state, const Poses& poses, const Poses& truth) {
  const auto pairs = motion::pair_by_time(poses, truth);
  if (pairs.size() < 2) return state.SkipWithError("no poses");
  std::vector<double> steps;
  for (size_t k = 1; k < pairs.size(); ++k) {
    const Eigen::Isometry3d step = pairs[k - 1].truth.inverse() * pairs[k].truth;
    const Eigen::Isometry3d found = pairs[k - 1].estimate.inverse() * pairs[k].estimate;
    steps.push_back((step.inverse() * found).translation().norm());
  }
  state.counters["step_mm"] = 1000 * median(steps);
  // In the vehicle's axes at the end, from the first pose on.
  const auto& [stamp, estimate, last] = pairs.back();
  const Eigen::Isometry3d end = pairs.front().estimate.inverse() * estimate;
  const Eigen::Isometry3d true_end = pairs.front().truth.inverse() * last;
  const Eigen::Vector3d error =
      true_end.linear().transpose() * (end.translation() - true_end.translation());
  state.counters["along_m"] = error.x();
  state.counters["across_m"] = error.y();
  state.counters["height_m"] = error.z();
  state.counters["poses"] = static_cast<double>(pairs.size());
  if (const motion::KittiError kitti = motion::kitti_error(pairs); kitti.usable()) {
    state.counters["kitti_percent"] = 100 * kitti.translation;
    state.counters["kitti_deg_per_100m"] = 100 * kitti.rotation / kDegree;
  }
}

// --- KITTI raw 0009 ---

template <class Odometry>
void follow_0009(benchmark::State& state, bool corrected) {
  const char* root = std::getenv("INFUSE_REAL_DATA");
  const std::filesystem::path folder = root == nullptr ? "" : root;
  kitti::RawDrive drive = kitti::read_raw_0009(folder / "drives/kitti_raw_0009");
  if (drive.sweeps.empty()) return state.SkipWithError("no KITTI raw 0009 under INFUSE_REAL_DATA");
  Poses truth;
  for (size_t k = 0; k < drive.sweeps.size(); ++k) {
    if (corrected) kitti::correct_vertical_angle(drive.sweeps[k]);
    truth.push_back({middle(drive.sweeps[k]), drive.truth[k]});
  }
  Odometry odometry(Eigen::Isometry3d::Identity());
  for (auto _ : state) {
    for (const Sweep& sweep : drive.sweeps) {
      state.PauseTiming();
      odometry.prepare(sweep);
      state.ResumeTiming();
      odometry.add(sweep);
    }
  }
  score(state, odometry.poses(), truth);
}

// --- simulated drives ---

/// A drive and its truth; without `poses` if it could not be made.
struct SimulatedDrive {
  std::filesystem::path folder;
  Poses truth;
};

/// The town's scenario, or the same along KITTI 00's route.
SimulatedDrive simulated_drive(bool recorded_route) {
  SimulatedDrive out;
  if (recorded_route) {
    const char* root = std::getenv("INFUSE_REAL_DATA");
    const std::string recorded = std::string(root == nullptr ? "" : root) + "/street/00";
    const std::string route = (bench_drives_folder() / "00.txt").string();
    std::filesystem::create_directories(bench_drives_folder());
    if (!std::filesystem::exists(recorded + ".txt.bz2") ||
        std::system(("bunzip2 -c " + recorded + ".txt.bz2 > " + route).c_str()) != 0) {
      return out;
    }
    out.folder = rendered_drive("lidar_kitti_route", "lidar_kitti_00",
                                " --map " + recorded + ".osm.bz2 --trajectory " + route);
  } else {
    out.folder = rendered_drive("lidar_town");
  }
  const auto poses = recording::read_trajectory(out.folder / "truth/poses.tum");
  if (!poses) return out;
  for (const auto& pose : *poses) out.truth.push_back({pose.stamp, pose.T_frame_body});
  return out;
}

template <class Odometry>
void follow_simulated(benchmark::State& state, bool recorded_route) {
  const SimulatedDrive drive = simulated_drive(recorded_route);
  if (drive.truth.empty()) return state.SkipWithError("no such drive");
  auto setup = daemon::open_drive(drive.folder, {}, {});
  if (!setup) return state.SkipWithError(setup.error().message().c_str());
  Odometry odometry(setup->rig.lidars[0].T_vehicle_lidar);
  for (auto _ : state) {
    state.PauseTiming();
    daemon::play_lidar(
        *setup, 0,
        [&](const Sweep& sweep) {
          odometry.prepare(sweep);
          state.ResumeTiming();
          odometry.add(sweep);
          state.PauseTiming();
        },
        [](const daemon::VehicleSample&) {}, [](const recording::DriveEvent&) { return true; });
    state.ResumeTiming();
  }
  score(state, odometry.poses(), drive.truth);
}

/// Writes beside a drive one that has the lidar and one other source; returns its folder.
std::filesystem::path with_sources(const std::filesystem::path& folder, bool wheels) {
  const auto drive = recording::Drive::open(folder);
  if (!drive) return {};
  recording::DriveDescription description = drive->description;
  description.gnss.clear();
  description.gnss_lidar.clear();
  if (wheels) description.imu.clear();
  if (!wheels) description.can.reset();
  const std::filesystem::path out = folder.string() + (wheels ? ".wheels" : ".gyro");
  std::filesystem::remove_all(out);
  using Copy = std::filesystem::copy_options;
  std::filesystem::copy(folder, out, Copy::recursive | Copy::create_hard_links);
  std::filesystem::remove(out / "drive.toml");
  if (!text::write_text(out / "drive.toml", recording::format_drive(description))) return {};
  return out;
}

/// The lidar with wheels or an inertial unit, by the daemon.
void replay_simulated(benchmark::State& state, bool recorded_route, bool wheels) {
  const SimulatedDrive drive = simulated_drive(recorded_route);
  if (drive.truth.empty()) return state.SkipWithError("no such drive");
  const auto folder = with_sources(drive.folder, wheels);
  if (folder.empty() ||
      !text::write_text(folder / "infused.toml", "[odometry]\nuse_lidar = true\n")) {
    return state.SkipWithError("cannot write the drive");
  }
  const std::string command = programs_folder() + "/infused --replay " + folder.string() +
                              " --config " + (folder / "infused.toml").string() + " --trajectory " +
                              (folder / "found.tum").string() + " >&2";
  for (auto _ : state) {
    if (std::system(command.c_str()) != 0) return state.SkipWithError("infused failed");
  }
  const auto found = recording::read_trajectory(folder / "found.tum");
  if (!found) return state.SkipWithError("no trajectory");
  Poses poses;
  for (const auto& pose : *found) poses.push_back({pose.stamp, pose.T_frame_body});
  score(state, poses, drive.truth);
}

void once(benchmark::internal::Benchmark* benchmark, const std::string& name) {
  benchmark->Name("registration/odometry/" + name)->Iterations(1)->Unit(benchmark::kSecond);
}

bool add_benchmarks() {
  using benchmark::RegisterBenchmark;
  for (const bool corrected : {false, true}) {
    const std::string name = corrected ? "0009_vertical" : "0009";
    once(RegisterBenchmark("ours", follow_0009<Ours>, corrected), name);
#ifdef INFUSE_PEER_KISS_ICP
    once(RegisterBenchmark("kiss", follow_0009<KissIcp<true>>, corrected),
         name + "/baseline:kiss_icp");
    once(RegisterBenchmark("kiss", follow_0009<KissIcp<false>>, corrected),
         name + "/baseline:kiss_icp_not_deskewed");
#endif
  }
  for (const bool recorded_route : {false, true}) {
    const std::string name = recorded_route ? "kitti_00" : "town";
    once(RegisterBenchmark("ours", follow_simulated<Ours>, recorded_route), name);
#ifdef INFUSE_PEER_KISS_ICP
    once(RegisterBenchmark("kiss", follow_simulated<KissIcp<true>>, recorded_route),
         name + "/baseline:kiss_icp");
#endif
    once(RegisterBenchmark("wheels", replay_simulated, recorded_route, true), name + "_wheels");
    once(RegisterBenchmark("gyro", replay_simulated, recorded_route, false), name + "_gyro");
  }
  return true;
}

[[maybe_unused]] const bool kAdded = add_benchmarks();

}  // namespace
}  // namespace infuse
