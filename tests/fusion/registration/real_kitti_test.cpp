// Real sweeps of an HDL-64E: KITTI odometry 00 and KITTI raw 0009.

#include "tests/real_kitti.hpp"
#include "drivers/measurement/angles.hpp"
#include "fusion/registration/gicp.hpp"
#include "fusion/registration/lidar_trajectory.hpp"
#include "fusion/registration/refine.hpp"
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

/// The returns of every fourth beam: of 64 at 1/3° and 1/2° 16 remain.
Sweep thinned(const Sweep& sweep) {
  Sweep out;
  for (size_t i = 0; i < sweep.size(); ++i) {
    const double elevation = std::atan2(sweep.z[i], std::hypot(sweep.x[i], sweep.y[i])) / kDegree;
    const double beam = elevation > -8.6 ? std::round(3 * (2 - elevation))
                                         : 32 + std::round(2 * (-8.83 - elevation));
    if (std::fmod(beam, 4) != 1) continue;
    out.x.push_back(sweep.x[i]), out.y.push_back(sweep.y[i]), out.z.push_back(sweep.z[i]);
  }
  return out;
}

// All beams are the truth. Planes of a beam's own cone hold sweeps of few beams to each other's
// rings: without the limit the median error of the rotation is 0.20°, and M² / 6 is 12.
TEST(RealKitti, SixteenBeamsOf0009AlignAsAllDo) {
  INFUSE_REAL_DATA_OR_SKIP(folder, "drives/kitti_raw_0009");
  const kitti::RawDrive drive = kitti::read_raw_0009(folder);
  const auto prepare = [](const Sweep& sweep, double voxel_size) {
    return prepare_cloud({sweep.x, sweep.y, sweep.z}, sweep_options(voxel_size));
  };
  std::vector<double> rotations;
  double mean = 0;
  for (size_t k = 0; k + 5 < drive.sweeps.size(); k += 5) {
    const Sweep &target = drive.sweeps[k], &source = drive.sweeps[k + 5];
    const Eigen::Isometry3d guess = drive.truth[k].inverse() * drive.truth[k + 5];
    const RegistrationResult all =
        refine(prepare(target, 0.25), prepare(source, 0.25).cloud, guess);
    const RegistrationResult few =
        refine(prepare(thinned(target), 0.4), prepare(thinned(source), 0.4).cloud, guess);
    ASSERT_TRUE(all.usable() && few.usable()) << k;
    const geometry::Vector6 error =
        geometry::log(all.T_target_source * few.T_target_source.inverse());
    rotations.push_back(error.head<3>().norm());
    mean += error.dot(few.covariance.ldlt().solve(error)) / 6;
  }
  mean /= static_cast<double>(rotations.size());
  std::nth_element(rotations.begin(), rotations.begin() + 4, rotations.end());
  RecordProperty("median_deg", std::to_string(rotations[4] / kDegree));
  RecordProperty("normalised", std::to_string(mean));
  EXPECT_LT(rotations[4], 0.16 * kDegree);
  EXPECT_LT(mean, 6);
}

}  // namespace
}  // namespace infuse::registration
