// Real sweeps of an HDL-64E: KITTI odometry 00 and KITTI raw 0009.

#include "tests/real_kitti.hpp"
#include "drivers/measurement/angles.hpp"
#include "fusion/registration/gicp.hpp"
#include "fusion/registration/lidar_trajectory.hpp"
#include "tests/real_data.hpp"

namespace infuse::registration {
namespace {

TEST(RealKitti, GicpAgreesWithThePublishedPoseOf00) {
  INFUSE_REAL_DATA_OR_SKIP(folder, "registration/kitti_odometry_00");
  const auto poses = kitti::read_poses(folder / "poses_gt_cam0.txt");
  const Eigen::Isometry3d T_camera_lidar = kitti::read_poses(folder / "calib_P2_Tr.txt").back();
  const Eigen::Isometry3d truth =
      T_camera_lidar.inverse() * poses[94].inverse() * poses[95] * T_camera_lidar;
  const Sweep target = kitti::read_sweep(folder / "velodyne/000094.bin");
  const Sweep source = kitti::read_sweep(folder / "velodyne/000095.bin");
  const RegistrationResult result =
      gicp(prepare_cloud({target.x, target.y, target.z}),
           prepare_cloud({source.x, source.y, source.z}).cloud, Eigen::Isometry3d::Identity());
  ASSERT_TRUE(result.usable()) << result.reason;
  const geometry::Vector6 error = geometry::log(truth * result.T_target_source.inverse());
  RecordProperty("error_mm", std::to_string(1000 * error.tail<3>().norm()));
  RecordProperty("error_deg", std::to_string(error.head<3>().norm() / kDegree));
  EXPECT_LT(error.tail<3>().norm(), 0.015);
  EXPECT_LT(error.head<3>().norm(), 0.03 * kDegree);
}

TEST(RealKitti, TheLidarAloneFollows0009) {
  INFUSE_REAL_DATA_OR_SKIP(folder, "drives/kitti_raw_0009");
  const kitti::RawDrive drive = kitti::read_raw_0009(folder);
  const auto& truth = drive.truth;
  constexpr size_t kSweeps = 51;
  ASSERT_EQ(drive.sweeps.size(), kSweeps);
  LidarTrajectory trajectory(Eigen::Isometry3d::Identity());
  std::vector<double> errors;
  Eigen::Isometry3d T_first_last = Eigen::Isometry3d::Identity();
  for (size_t k = 0; k < kSweeps; ++k) {
    const LidarOdometryResult& result = trajectory.add(drive.sweeps[k]);
    if (k == 0) continue;
    ASSERT_TRUE(result.usable()) << k << ": " << result.reason;
    const Eigen::Isometry3d step = truth[k - 1].inverse() * truth[k];
    errors.push_back((step.inverse() * result.motion.T_from_to).translation().norm());
    T_first_last = result.T_map_vehicle;
  }
  std::nth_element(errors.begin(), errors.begin() + 25, errors.end());
  EXPECT_LT(errors[25], 0.022);
  const Eigen::Vector3d end = truth[kSweeps - 1].translation() - T_first_last.translation();
  RecordProperty("median_step_mm", std::to_string(1000 * errors[25]));
  RecordProperty("end", std::to_string(end.x()) + " " + std::to_string(end.y()));
  EXPECT_LT(end.head<2>().cwiseAbs().maxCoeff(), 0.4);
}

}  // namespace
}  // namespace infuse::registration
