// The global guess on KITTI's raw drive 0009, the source turned to any heading.

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include <spdlog/fmt/fmt.h>

#include "drivers/measurement/angles.hpp"
#include "drivers/recording/sweep_files.hpp"
#include "fusion/registration/global_guess.hpp"
#include "tests/real_data.hpp"

namespace infuse::registration {
namespace {

constexpr const char* kDrive = "drives/kitti_raw_0009";

/// T_first_k of every sweep, by attitude and integrated velocity.
std::vector<Eigen::Isometry3d> read_poses(const std::filesystem::path& drive) {
  std::ifstream file(drive / "poses_velodyne_from_oxts_velocity.txt");
  std::vector<Eigen::Isometry3d> poses;
  for (std::string line; std::getline(file, line);) {
    std::istringstream row(line);
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    for (int i = 0; i < 12; ++i) row >> T(i / 4, i % 4);
    if (row) poses.push_back(T);
  }
  return poses;
}

Sweep read_sweep(const std::filesystem::path& path) {
  Sweep sweep;
  const auto read = recording::read_sweep_file(path, sweep);
  EXPECT_TRUE(read) << read.error().message();
  return sweep;
}

std::filesystem::path sweep_path(const std::filesystem::path& drive, int k) {
  return drive / "2011_09_26/2011_09_26_drive_0009_sync/velodyne_points/data" /
         fmt::format("{:010}.bin", k);
}

geometry::PointsView points_of(const Sweep& sweep) { return {sweep.x, sweep.y, sweep.z}; }

TEST(RealGlobalGuess, KittiSweepsTenMetresApartAlignFromAnyHeading) {
  INFUSE_REAL_DATA_OR_SKIP(drive, kDrive);
  const auto poses = read_poses(drive);
  ASSERT_GE(poses.size(), 50U);
  for (const auto& [target, heading_deg] : {std::pair(0, 180.0), {20, -60.0}, {40, 90.0}}) {
    const int source = target + 9;
    const Sweep there = read_sweep(sweep_path(drive, target));
    Sweep here = read_sweep(sweep_path(drive, source));
    Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
    turn.rotate(Eigen::AngleAxisd(heading_deg * kDegree, Eigen::Vector3d::UnitZ()));
    for (size_t i = 0; i < here.size(); ++i) {
      const Eigen::Vector3f p =
          turn.cast<float>() * Eigen::Vector3f(here.x[i], here.y[i], here.z[i]);
      here.x[i] = p.x();
      here.y[i] = p.y();
    }
    const RegistrationResult found = find_global_guess(points_of(there), points_of(here));
    ASSERT_TRUE(found.usable()) << found.reason;
    const Eigen::Isometry3d truth = poses[static_cast<size_t>(target)].inverse() *
                                    poses[static_cast<size_t>(source)] * turn.inverse();
    // The reference itself is right to 0.14 m over ten sweeps.
    EXPECT_LT((found.T_target_source.translation() - truth.translation()).norm(), 0.3) << target;
    EXPECT_LT(geometry::log(found.T_target_source * truth.inverse()).head<3>().norm(),
              1.5 * kDegree)
        << target;
  }
}

TEST(RealGlobalGuess, SweepsOfOtherStreetsAreRefused) {
  INFUSE_REAL_DATA_OR_SKIP(drive, kDrive);
  INFUSE_REAL_DATA_OR_SKIP(other, "registration/kitti_odometry_00/velodyne/000094.bin");
  const Sweep there = read_sweep(sweep_path(drive, 25)), here = read_sweep(other);
  const RegistrationResult found = find_global_guess(points_of(there), points_of(here));
  EXPECT_FALSE(found.usable());
  EXPECT_STRNE(found.reason, "");
}

}  // namespace
}  // namespace infuse::registration
