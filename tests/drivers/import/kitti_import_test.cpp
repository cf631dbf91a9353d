#include "drivers/import/kitti_import.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "drivers/gnss/gnss_csv.hpp"
#include "drivers/recording/drive_source.hpp"
#include "drivers/recording/drive_toml.hpp"
#include "drivers/recording/imu_csv.hpp"
#include "drivers/recording/speed_csv.hpp"
#include "drivers/recording/times_csv.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "tests/drivers/import/kitti_projection.hpp"
#include "tests/real_data.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::importers {
namespace {

using ::testing::HasSubstr;

TEST(KittiImportSummary, ImportsTheRealObjectLayout) {
  INFUSE_REAL_DATA_OR_SKIP(path, "calibration/kitti");
  const ScratchFolder folder;
  const auto result = import_kitti(path, folder / "drive");
  ASSERT_TRUE(result) << result.error().message();
  EXPECT_EQ(result->layout, KittiLayout::kObject);
  EXPECT_EQ(result->sweeps, 17u);
  EXPECT_EQ(result->images, 17u);
  EXPECT_FALSE(result->times_trusted);
  EXPECT_TRUE(result->notes.empty());

  const auto drive = recording::Drive::open(folder / "drive");
  ASSERT_TRUE(drive) << drive.error().message();
  EXPECT_FALSE(drive->description.times_trusted);
  ASSERT_EQ(drive->description.rig.cameras.size(), 1u);
  const CameraMount& camera = drive->description.rig.cameras[0];
  EXPECT_EQ(camera.name, "image_2");
  EXPECT_EQ(camera.intrinsics.width, 1242);
  EXPECT_EQ(camera.intrinsics.height, 375);
  EXPECT_EQ(camera.intrinsics.fx, 721.5377);
  EXPECT_EQ(camera.intrinsics.cy, 172.854);
  // T = [I | K⁻¹ p] R0 Tr by hand.
  const std::filesystem::path calib = path / "calib/000001.txt";
  const std::vector<double> P = numbers_after(calib, "P2");
  const Matrix R0 = to_matrix(numbers_after(calib, "R0_rect"), 3);
  const Matrix Tr = to_matrix(numbers_after(calib, "Tr_velo_to_cam"), 4);
  Matrix offset = to_matrix({}, 4);
  offset[2][3] = P[11];
  offset[0][3] = (P[3] - P[2] * P[11]) / P[0];
  offset[1][3] = (P[7] - P[6] * P[11]) / P[5];
  EXPECT_NEAR(offset[0][3], 0.06, 0.001);  // the stereo offset of data/INDEX.md
  const Matrix T = multiply(offset, multiply(R0, Tr));
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      EXPECT_NEAR(camera.T_camera_lidar.matrix()(i, j),
                  T[static_cast<size_t>(i)][static_cast<size_t>(j)], 2e-7);
    }
  }
  const auto truth = recording::read_rig(drive->resolve(drive->description.truth_rig));
  ASSERT_TRUE(truth);
  EXPECT_EQ(truth->cameras[0].T_camera_lidar.matrix(), camera.T_camera_lidar.matrix());

  // Sweeps are 0.1 s apart and have the stamps of their images. Points are projected to the same
  // pixels as by KITTI's formula, and a forward camera of 81° covers about a sixth of a turn.
  const Matrix chain = multiply(to_matrix(P, 4), multiply(R0, Tr));
  auto source = recording::DriveSource::open(*drive);
  ASSERT_TRUE(source) << source.error().message();
  recording::DriveEvent event;
  int64_t sweeps = 0, images = 0;
  while (source->next(event)) {
    if (std::holds_alternative<recording::ImageEvent>(event.content)) {
      EXPECT_EQ(event.stamp.ns(), 100'000'000 * images++);
      continue;
    }
    EXPECT_EQ(event.stamp.ns(), 100'000'000 * sweeps++);
    const Sweep& sweep = *std::get<recording::SweepEvent>(event.content).sweep;
    EXPECT_FALSE(sweep.clock.trusted);
    size_t in_view = 0, compared = 0;
    for (size_t i = 0; i < sweep.size(); i += 7) {
      const Pixel pixel = project(chain, sweep.x[i], sweep.y[i], sweep.z[i]);
      if (pixel.depth < 1) continue;
      const Eigen::Vector3d p =
          camera.T_camera_lidar * Eigen::Vector3d(sweep.x[i], sweep.y[i], sweep.z[i]);
      const double u = camera.intrinsics.fx * p.x() / p.z() + camera.intrinsics.cx;
      const double v = camera.intrinsics.fy * p.y() / p.z() + camera.intrinsics.cy;
      const bool inside = u >= 0 && u < 1242 && v >= 0 && v < 375;
      if (inside) {
        ASSERT_NEAR(u, pixel.u, 1e-2);
        ASSERT_NEAR(v, pixel.v, 1e-2);
      }
      in_view += inside;
      ++compared;
    }
    const double share = static_cast<double>(in_view) * 7 / static_cast<double>(sweep.size());
    EXPECT_GT(share, 0.10);
    EXPECT_LT(share, 0.25);
    EXPECT_GT(compared, 1000u);
  }
  EXPECT_EQ(sweeps, 17);
  EXPECT_EQ(images, 17);
  EXPECT_TRUE(source->notes().empty());
  EXPECT_THAT(folder.read("drive/sweeps/times.csv"), HasSubstr("400000000,100000.bin\n"));
}

TEST(KittiImportSummary, ImportsTheRealOdometryLayout) {
  INFUSE_REAL_DATA_OR_SKIP(path, "registration/kitti_odometry_00");
  const ScratchFolder folder;
  const auto result = import_kitti(path, folder / "drive");
  ASSERT_TRUE(result) << result.error().message();
  EXPECT_EQ(result->layout, KittiLayout::kOdometry);
  EXPECT_EQ(result->sweeps, 4u);
  EXPECT_EQ(result->poses, 4541u);
  EXPECT_TRUE(result->times_trusted);

  const auto drive = recording::Drive::open(folder / "drive");
  ASSERT_TRUE(drive) << drive.error().message();
  const auto sweeps = recording::index_sweeps(drive->resolve("sweeps"));
  ASSERT_TRUE(sweeps);
  ASSERT_EQ(sweeps->entries.size(), 4u);
  // Deskewed to the stamp of the image, 1.037359e-01 s, which is the middle of the turn.
  const recording::SequenceEntry& second = sweeps->entries[1];
  EXPECT_NEAR(static_cast<double>((second.stamp + second.span / 2).ns()), 103'735'900, 1);
  EXPECT_NEAR(to_seconds(second.span), 0.1037, 1e-3);
  EXPECT_TRUE(drive->description.lidars[0].deskewed);

  const auto poses = recording::read_trajectory(drive->resolve(drive->description.truth_poses));
  ASSERT_TRUE(poses);
  ASSERT_EQ(poses->size(), 4541u);
  const Eigen::Isometry3d first = poses->front().T_frame_body;
  EXPECT_LT((first.matrix() - Eigen::Matrix4d::Identity()).norm(), 1e-5);
  // The vehicle moves forward: 0.86 m along x in the first step, as in the file.
  const Eigen::Vector3d step = poses->at(1).T_frame_body.translation();
  EXPECT_NEAR(step.x(), 0.858, 0.01);
  EXPECT_LT(std::abs(step.z()), 0.05);
  // Path lengths do not depend on the frame, except for the lever arm between camera and vehicle.
  double vehicle = 0;
  for (size_t i = 1; i < poses->size(); ++i) {
    vehicle +=
        (poses->at(i).T_frame_body.translation() - poses->at(i - 1).T_frame_body.translation())
            .norm();
  }
  EXPECT_NEAR(vehicle, 3724, 40);  // KITTI states 3724 m for sequence 00
  // T_95_94 of the lidar from the imported rig and poses, compared with that from cam0's poses.
  const auto lidar_motion = [&](size_t a, size_t b) {
    const Eigen::Isometry3d T_vehicle_lidar = drive->description.rig.lidars[0].T_vehicle_lidar;
    return (poses->at(b).T_frame_body * T_vehicle_lidar).inverse() * poses->at(a).T_frame_body *
           T_vehicle_lidar;
  };
  std::ifstream in(path / "poses_gt_cam0.txt");
  std::string line;
  std::vector<Matrix> camera_poses;
  while (std::getline(in, line)) {
    std::istringstream words(line);
    std::vector<double> numbers;
    for (double number = 0; words >> number;) numbers.push_back(number);
    camera_poses.push_back(to_matrix(numbers, 4));
  }
  ASSERT_EQ(camera_poses.size(), 4541u);
  const Matrix Tr = to_matrix(numbers_after(path / "calib_P2_Tr.txt", "Tr"), 4);
  // pose₉₅ · Tr · T_95_94 = pose₉₄ · Tr
  const Eigen::Isometry3d motion = lidar_motion(94, 95);
  Matrix T_95_94{};
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      T_95_94[static_cast<size_t>(i)][static_cast<size_t>(j)] = motion.matrix()(i, j);
    }
  }
  const Matrix left = multiply(multiply(camera_poses[95], Tr), T_95_94);
  const Matrix right = multiply(camera_poses[94], Tr);
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 4; ++j) EXPECT_NEAR(left[i][j], right[i][j], j == 3 ? 1e-4 : 1e-5);
  }
}

TEST(KittiImportSummary, SkipsAndNotesFramesWithAnotherCalibration) {
  const ScratchFolder folder;
  const std::string calib =
      "P2: 700 0 600 0 0 700 180 0 0 0 1 0\nTr_velo_to_cam: 0 -1 0 0 0 0 -1 0 1 0 0 ";
  for (const auto& [name, offset] : {std::pair("000000", "0"), {"000001", "0"}, {"000002", "1"}}) {
    folder.write(std::string("in/calib/") + name + ".txt", calib + offset + "\n");
    folder.write(std::string("in/velodyne/") + name + ".bin", std::string(16, '\0'));
  }
  folder.write("in/velodyne/000007.bin", std::string(16, '\0'));
  const auto result = import_kitti(folder / "in", folder / "drive");
  ASSERT_TRUE(result) << result.error().message();
  EXPECT_EQ(result->sweeps, 2u);
  std::string notes;
  for (const Error& note : result->notes) notes += note.message() + "\n";
  EXPECT_THAT(notes, HasSubstr("2 calibrations"));
  EXPECT_THAT(notes, HasSubstr("2 files of frames with another calibration"));
}

}  // namespace
}  // namespace infuse::importers
