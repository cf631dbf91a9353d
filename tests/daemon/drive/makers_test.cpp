// The whole way from the packets of a maker to motion: simulated lidars of like beams do equally
// well whoever made them. The table of all makers: tests/study/makers.

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <map>

#include "daemon/playback/play_lidar.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/registration/lidar_trajectory.hpp"
#include "tests/daemon/drive/simulated.hpp"

namespace infuse::daemon {
namespace {

/// A return of truth/top/NNNNNN.bin.
struct TrueReturn {
  float x, y, z, true_range, range;
  int32_t time_ns;
  uint16_t ring, object;
  uint8_t label, reflectivity;
  uint16_t slot;
};
static_assert(sizeof(TrueReturn) == 32);

std::vector<TrueReturn> read_turn(const std::filesystem::path& path) {
  const std::string bytes = read_file(path);
  std::vector<TrueReturn> turn(bytes.size() / sizeof(TrueReturn));
  std::memcpy(turn.data(), bytes.data(), turn.size() * sizeof(TrueReturn));
  return turn;
}

struct Errors {
  double deskew_m = 0;    ///< rms distance of deskewed returns from where they were
  double odometry_m = 0;  ///< at the end of the drive, by the lidar alone
  size_t returns = 0;
};

class MakerDrive {
 public:
  explicit MakerDrive(const std::string& model) {
    const auto made = simulate(drive_, R"(duration_s = 2.4
[world]
map = "altfeld.osm"
route = [100, 104, 112]
build_radius_m = 60
[vehicle]
speed = 10
start_speed = 10
[[lidar]]
model = ")" + model + R"("
rays_per_pulse = 1
range_noise_m = 0.01
position = [1.0, 0.0, 1.9]
[truth]
clouds = true
)");
    EXPECT_TRUE(made) << made.error().message();
  }

  Errors run() {
    auto setup = open_drive(drive_, {});
    EXPECT_TRUE(setup) << setup.error().message();
    T_vehicle_lidar_ = setup->rig.lidars[0].T_vehicle_lidar;
    registration::LidarTrajectory track(T_vehicle_lidar_);
    std::optional<Eigen::Isometry3d> T_map_true;  // of the results' map, by the first pose
    Eigen::Isometry3d error = Eigen::Isometry3d::Identity();
    size_t number = 0;
    const LidarCounters counters = play_lidar(
        *setup, 0,
        [&](const Sweep& sweep) {
          const auto& result = track.add(sweep);
          if (number++ < 2 || !result.usable()) return;
          const Eigen::Isometry3d T_true = true_pose(result.stamp);
          if (!T_map_true) T_map_true = result.T_map_vehicle * T_true.inverse();
          error = (*T_map_true * T_true).inverse() * result.T_map_vehicle;
          if (track.deskewed().usable()) compare(sweep, track.deskewed(), T_true);
        },
        [](const VehicleSample&) {}, [](const recording::DriveEvent&) { return true; });
    EXPECT_EQ(counters.malformed + counters.lost_network, 0U);
    EXPECT_GE(number, 24U);
    return {std::sqrt(squares_ / static_cast<double>(returns_)), error.translation().norm(),
            returns_};
  }

 private:
  Eigen::Isometry3d true_pose(Stamp stamp) {
    if (poses_.empty()) {
      poses_ = recording::read_trajectory(drive_ / "truth/poses.tum").value();
    }
    size_t i = 1;
    while (i + 1 < poses_.size() && poses_[i].stamp < stamp) ++i;
    const auto &before = poses_[i - 1], &after = poses_[i];
    return geometry::interpolate(
        before.T_frame_body, after.T_frame_body,
        to_seconds(stamp - before.stamp) / to_seconds(after.stamp - before.stamp));
  }

  /// Returns are found among the true ones by ring and time.
  void compare(const Sweep& sweep, const motion::DeskewedSweep& deskewed,
               const Eigen::Isometry3d& T_map_vehicle) {
    // Turns are cut where sweeps are; the first has number 0.
    const auto turn_number = std::lround(to_seconds(sweep.stamp - true_start()) * 10);
    char name[32];
    std::snprintf(name, sizeof name, "%06ld.bin", turn_number);
    std::map<std::pair<int, int32_t>, const TrueReturn*> by_place;
    const auto turn = read_turn(drive_ / "truth/top" / name);
    const auto tick = [](int32_t ns) { return (ns + 2000) / 4000; };
    for (const TrueReturn& r : turn) by_place[{r.ring, tick(r.time_ns)}] = &r;
    const Eigen::Isometry3d T_map_lidar = T_map_vehicle * T_vehicle_lidar_;
    const Eigen::Isometry3d T_map_turn =
        true_pose(true_start() + from_seconds(turn_number * 0.1)) * T_vehicle_lidar_;
    for (size_t i = 0; i < sweep.size(); i += 7) {
      const auto found = by_place.find({sweep.ring[i], tick(sweep.time_offset_ns[i])});
      if (found == by_place.end() || found->second->object != 0) continue;
      const Eigen::Vector3d at =
          T_map_lidar * Eigen::Vector3d(deskewed.x[i], deskewed.y[i], deskewed.z[i]);
      const Eigen::Vector3d truth =
          T_map_turn * Eigen::Vector3d(found->second->x, found->second->y, found->second->z);
      const double distance = (at - truth).norm();
      if (distance > 0.5) continue;  // another firing
      squares_ += distance * distance;
      ++returns_;
    }
  }

  Stamp true_start() {
    static_cast<void>(true_pose(Stamp()));
    return poses_.front().stamp;
  }

  TemporaryFolder folder_;
  std::filesystem::path drive_ = folder_ / "drive";
  Eigen::Isometry3d T_vehicle_lidar_;
  std::vector<recording::TrajectoryPose> poses_;
  double squares_ = 0;
  size_t returns_ = 0;
};

TEST(MakersDrive, AnXt32DoesAsWellAsAnHdl32e) {
  const Errors known = MakerDrive("HDL-32E").run();
  const Errors other = MakerDrive("XT32").run();
  ASSERT_GT(known.returns, 10'000U);
  ASSERT_GT(other.returns, 10'000U);
  EXPECT_LT(known.deskew_m, 0.06);
  EXPECT_LT(other.deskew_m, 1.2 * known.deskew_m);
  EXPECT_LT(other.odometry_m, 1.2 * known.odometry_m + 0.02);
              other.odometry_m);
}

}  // namespace
}  // namespace infuse::daemon
