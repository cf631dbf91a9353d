#include "drivers/import/kitti_calibration.hpp"

#include <string>

#include "drivers/import/calibration_text.hpp"

namespace infuse::importers {
namespace {

namespace fs = std::filesystem;

// Reads R and T of a calib_*_to_*.txt.
Result<Eigen::Isometry3d> read_transform(const CalibrationText& file) {
  auto T = file.rigid({"R"}, 3);
  if (!T) return T;
  const auto translation = file.matrix({"T"}, 3, 1);
  if (!translation) return tl::unexpected(translation.error());
  T->translation() = translation->topLeftCorner<3, 1>();
  return T;
}

Result<void> read_projection(const CalibrationText& file, const char* key, size_t camera,
                             KittiCalibration& calibration) {
  if (file.find({key}) == nullptr) return {};
  const auto P = file.matrix({key}, 3, 4);
  if (!P) return tl::unexpected(P.error());
  const Eigen::Matrix<double, 3, 4> projection = P->topRows<3>();
  const bool pinhole = projection(0, 0) > 0 && projection(1, 1) > 0 && projection(0, 1) == 0 &&
                       projection(1, 0) == 0 &&
                       projection.row(2).head<3>() == Eigen::RowVector3d(0, 0, 1);
  if (!pinhole) {
    return fail(std::string(key) + " is not a rectified projection", file.name(),
                "expected fx 0 cx px  0 fy cy py  0 0 1 pz");
  }
  calibration.projection[camera] = projection;
  return {};
}

constexpr std::array<const char*, 4> kProjectionKeys = {"P0", "P1", "P2", "P3"};
constexpr std::array<const char*, 4> kRawProjectionKeys = {"P_rect_00", "P_rect_01", "P_rect_02",
                                                           "P_rect_03"};

Result<void> read_projections(const CalibrationText& file, const std::array<const char*, 4>& keys,
                              KittiCalibration& calibration) {
  for (size_t camera = 0; camera < keys.size(); ++camera) {
    if (auto read = read_projection(file, keys[camera], camera, calibration); !read) return read;
  }
  return {};
}

}  // namespace

bool KittiCalibration::operator==(const KittiCalibration& other) const {
  const auto same_matrix = [](const auto& a, const auto& b) {
    return a.has_value() == b.has_value() && (!a || a->matrix() == b->matrix());
  };
  for (size_t i = 0; i < projection.size(); ++i) {
    if (!same_matrix(projection[i], other.projection[i])) return false;
  }
  return T_rectified_lidar.matrix() == other.T_rectified_lidar.matrix() &&
         same_matrix(T_lidar_imu, other.T_lidar_imu);
}

Eigen::Isometry3d KittiCalibration::T_camera_lidar(size_t camera) const {
  const Eigen::Matrix<double, 3, 4>& P = *projection[camera];
  const Eigen::Matrix3d K = P.leftCols<3>();
  const Eigen::Vector3d offset = K.triangularView<Eigen::Upper>().solve(P.col(3));
  return Eigen::Translation3d(offset) * T_rectified_lidar;
}

CameraIntrinsics KittiCalibration::intrinsics(size_t camera, int width, int height) const {
  const Eigen::Matrix<double, 3, 4>& P = *projection[camera];
  CameraIntrinsics intrinsics;
  intrinsics.width = width;
  intrinsics.height = height;
  intrinsics.fx = P(0, 0);
  intrinsics.fy = P(1, 1);
  intrinsics.cx = P(0, 2);
  intrinsics.cy = P(1, 2);
  return intrinsics;
}

Eigen::Isometry3d KittiCalibration::T_vehicle_lidar() const {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  if (T_lidar_imu) T.linear() = T_lidar_imu->linear().transpose();
  T.translation() = Eigen::Vector3d(0.76, 0, 1.73);
  return T;
}

Result<KittiCalibration> read_kitti_calibration(const fs::path& path) {
  const auto file = CalibrationText::read(path);
  if (!file) return tl::unexpected(file.error());
  KittiCalibration calibration;
  if (auto read = read_projections(*file, kProjectionKeys, calibration); !read)
    return tl::unexpected(read.error());
  const auto T_camera_lidar = file->rigid({"Tr_velo_to_cam", "Tr_velo_cam", "Tr"}, 4);
  if (!T_camera_lidar) return tl::unexpected(T_camera_lidar.error());
  calibration.T_rectified_lidar = *T_camera_lidar;
  if (file->find({"R0_rect", "R_rect"}) != nullptr) {
    const auto R = file->rigid({"R0_rect", "R_rect"}, 3);
    if (!R) return tl::unexpected(R.error());
    calibration.T_rectified_lidar = *R * *T_camera_lidar;
  }
  if (file->find({"Tr_imu_to_velo", "Tr_imu_velo"}) != nullptr) {
    const auto T_lidar_imu = file->rigid({"Tr_imu_to_velo", "Tr_imu_velo"}, 4);
    if (!T_lidar_imu) return tl::unexpected(T_lidar_imu.error());
    calibration.T_lidar_imu = *T_lidar_imu;
  }
  return calibration;
}

Result<KittiCalibration> read_kitti_raw_calibration(const fs::path& folder) {
  const auto cameras = CalibrationText::read(folder / "calib_cam_to_cam.txt");
  if (!cameras) return tl::unexpected(cameras.error());
  const auto lidar = CalibrationText::read(folder / "calib_velo_to_cam.txt");
  if (!lidar) return tl::unexpected(lidar.error());
  KittiCalibration calibration;
  if (auto read = read_projections(*cameras, kRawProjectionKeys, calibration); !read)
    return tl::unexpected(read.error());
  const auto R = cameras->rigid({"R_rect_00"}, 3);
  if (!R) return tl::unexpected(R.error());
  const auto T_camera_lidar = read_transform(*lidar);
  if (!T_camera_lidar) return tl::unexpected(T_camera_lidar.error());
  calibration.T_rectified_lidar = *R * *T_camera_lidar;
  if (fs::exists(folder / "calib_imu_to_velo.txt")) {
    const auto imu = CalibrationText::read(folder / "calib_imu_to_velo.txt");
    if (!imu) return tl::unexpected(imu.error());
    const auto T_lidar_imu = read_transform(*imu);
    if (!T_lidar_imu) return tl::unexpected(T_lidar_imu.error());
    calibration.T_lidar_imu = *T_lidar_imu;
  }
  return calibration;
}

}  // namespace infuse::importers
