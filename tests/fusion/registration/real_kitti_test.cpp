// Real sweeps of an HDL-64E: KITTI odometry 00 and KITTI raw 0009.

#include <fstream>
#include <numbers>
#include <sstream>

#include "drivers/measurement/angles.hpp"
#include "fusion/registration/gicp.hpp"
#include "fusion/registration/lidar_trajectory.hpp"
#include "tests/real_data.hpp"

namespace infuse::registration {
namespace {

Sweep read_sweep(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(stream)), {});
  Sweep sweep;
  sweep.resize(bytes.size() / 16);
  for (size_t i = 0; i < sweep.size(); ++i) {
    float point[3];
    std::memcpy(point, &bytes[16 * i], sizeof(point));
    sweep.x[i] = point[0], sweep.y[i] = point[1], sweep.z[i] = point[2];
  }
  return sweep;
}

/// Poses of a file with twelve numbers a line; other lines are left out.
std::vector<Eigen::Isometry3d> read_poses(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::vector<Eigen::Isometry3d> poses;
  for (std::string line; std::getline(stream, line);) {
    std::istringstream numbers(line.substr(line.find(':') + 1));
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    for (int i = 0; i < 12; ++i) numbers >> T.matrix()(i / 4, i % 4);
    if (numbers) poses.push_back(T);
  }
  return poses;
}

TEST(RealKitti, GicpAgreesWithThePublishedPoseOf00) {
  INFUSE_REAL_DATA_OR_SKIP(folder, "registration/kitti_odometry_00");
  const auto poses = read_poses(folder / "poses_gt_cam0.txt");
  const Eigen::Isometry3d T_camera_lidar = read_poses(folder / "calib_P2_Tr.txt").back();
  const Eigen::Isometry3d truth =
      T_camera_lidar.inverse() * poses[94].inverse() * poses[95] * T_camera_lidar;
  const Sweep target = read_sweep(folder / "velodyne/000094.bin");
  const Sweep source = read_sweep(folder / "velodyne/000095.bin");
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

/// Seconds of the day in a line such as "2011-09-26 13:04:32.351950336".
std::vector<double> read_stamps(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::vector<double> stamps;
  for (std::string line; std::getline(stream, line);) {
    int hours = 0, minutes = 0;
    double seconds = 0;
    std::sscanf(line.c_str(), "%*s %d:%d:%lf", &hours, &minutes, &seconds);
    stamps.push_back(3600 * hours + 60 * minutes + seconds);
  }
  return stamps;
}

TEST(RealKitti, TheLidarAloneFollows0009) {
  INFUSE_REAL_DATA_OR_SKIP(folder, "drives/kitti_raw_0009");
  const auto drive = folder / "2011_09_26/2011_09_26_drive_0009_sync/velodyne_points";
  const auto truth = read_poses(folder / "poses_velodyne_from_oxts_velocity.txt");
  const auto begins = read_stamps(drive / "timestamps_start.txt");
  const auto ends = read_stamps(drive / "timestamps_end.txt");
  LidarTrajectory trajectory(Eigen::Isometry3d::Identity());
  std::vector<double> errors;
  Eigen::Isometry3d T_first_last = Eigen::Isometry3d::Identity();
  constexpr size_t kSweeps = 51;
  for (size_t k = 0; k < kSweeps; ++k) {
    char name[32];
    std::snprintf(name, sizeof(name), "data/%010zu.bin", k);
    Sweep sweep = read_sweep(drive / name);
    // The sensor turns clockwise from the rear: its azimuth gives the time.
    sweep.stamp = Stamp::from_ns(0) + from_seconds(begins[k]);
    sweep.span = from_seconds(ends[k] - begins[k]);
    for (size_t i = 0; i < sweep.size(); ++i) {
      const double turn = 0.5 - std::atan2(sweep.y[i], sweep.x[i]) / (2 * std::numbers::pi);
      sweep.time_offset_ns[i] =
          static_cast<int32_t>(turn * static_cast<double>(sweep.span.count()));
    }
    const LidarOdometryResult& result = trajectory.add(sweep);
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
