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
#include "drivers/recording/sweep_files.hpp"
#include "drivers/recording/times_csv.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "tests/real_data.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::importers {
namespace {

using ::testing::HasSubstr;

// Reads the numbers after "KEY:" in a calibration file, independently of the code under test.
std::vector<double> numbers_after(const std::filesystem::path& file, const std::string& key) {
  std::ifstream in(file);
  std::string line;
  while (std::getline(in, line)) {
    if (line.rfind(key + ":", 0) != 0) continue;
    std::istringstream words(line.substr(key.size() + 1));
    std::vector<double> numbers;
    for (double number = 0; words >> number;) numbers.push_back(number);
    return numbers;
  }
  return {};
}

// rows × 3 or rows × 4 numbers, extended to 4 × 4 with the identity.
using Matrix = std::array<std::array<double, 4>, 4>;
Matrix to_matrix(const std::vector<double>& numbers, size_t columns) {
  Matrix m{};
  for (size_t i = 0; i < 4; ++i) m[i][i] = 1;
  for (size_t i = 0; i < numbers.size(); ++i) m[i / columns][i % columns] = numbers[i];
  return m;
}
Matrix multiply(const Matrix& a, const Matrix& b) {
  Matrix m{};
  for (size_t i = 0; i < 4; ++i) {
    for (size_t j = 0; j < 4; ++j) {
      for (size_t k = 0; k < 4; ++k) m[i][j] += a[i][k] * b[k][j];
    }
  }
  return m;
}

// KITTI's projection: P · R0 · Tr · x, divided by the third coordinate.
struct Pixel {
  double u, v, depth;
};
Pixel project(const Matrix& chain, double x, double y, double z) {
  const auto row = [&](size_t i) {
    return chain[i][0] * x + chain[i][1] * y + chain[i][2] * z + chain[i][3];
  };
  return {row(0) / row(2), row(1) / row(2), row(2)};
}

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

std::string text_of(const std::vector<Error>& notes) {
  std::string text;
  for (const Error& note : notes) text += note.message() + "\n";
  return text;
}

TEST(KittiImport, ImportsTheRealRawDriveWithTheTimesOfItsReturns) {
  INFUSE_REAL_DATA_OR_SKIP(path, "drives/kitti_raw_0009/2011_09_26/2011_09_26_drive_0009_sync");
  const ScratchFolder folder;
  const auto result = import_kitti(path, folder / "drive");
  ASSERT_TRUE(result) << result.error().message();
  EXPECT_EQ(result->sweeps, 51u);
  EXPECT_EQ(result->images, 51u);
  EXPECT_THAT(text_of(result->notes),
              HasSubstr("cut at the rear, each ring at an azimuth of its own, as the sweeps"));
  EXPECT_THAT(text_of(result->notes), HasSubstr("exposed 3 ms after the middle of their sweep"));

  const auto drive = recording::Drive::open(folder / "drive");
  ASSERT_TRUE(drive) << drive.error().message();
  const auto& turn = drive->description.lidars[0].turn;
  ASSERT_TRUE(turn);
  EXPECT_TRUE(turn->clockwise);
  EXPECT_EQ(turn->cut_deg, 180);
  // Where the range steps, because a driven metre lies between the begin and the end of a turn.
  ASSERT_EQ(turn->ring_cuts_deg.size(), 64u);
  const std::array seams{std::pair{12, 177.9}, std::pair{19, 182.1}, std::pair{25, 180.9},
                         std::pair{27, 187.4}, std::pair{37, 176.9}, std::pair{46, 182.6}};
  for (const auto& [ring, seam_deg] : seams)
    EXPECT_NEAR(turn->ring_cuts_deg[static_cast<size_t>(ring)], seam_deg, 0.4) << ring;
  const CameraMount& camera = drive->description.rig.cameras[0];
  EXPECT_NEAR(to_seconds(camera.stamp_delay), 0.0146, 0.0012);
  EXPECT_EQ(camera.stamp_delay_sigma, Duration(3'000'000));

  // Exposures are 3 ms after the lines of timestamps.txt; events are in the order in which they are
  // complete.
  std::ifstream lines(path / "velodyne_points/timestamps.txt");
  std::string line;
  auto source = recording::DriveSource::open(*drive);
  ASSERT_TRUE(source) << source.error().message();
  recording::DriveEvent event;
  size_t speeds = 0, sweeps = 0;
  Stamp exposure;
  while (source->next(event)) {
    speeds += std::holds_alternative<WheelOdometry>(event.content) ? 1 : 0;
    if (std::holds_alternative<recording::ImageEvent>(event.content)) {
      std::getline(lines, line);
      exposure = event.stamp;
      const double seconds = static_cast<double>(exposure.ns() % 60'000'000'000) * 1e-9;
      EXPECT_NEAR(seconds, std::stod(line.substr(17)) + 0.003, 1e-6);
    } else if (const auto* event_sweep = std::get_if<recording::SweepEvent>(&event.content)) {
      const Sweep& sweep = *event_sweep->sweep;
      ASSERT_TRUE(sweep.has_times);
      EXPECT_NEAR(to_seconds(sweep.span), 0.1035, 0.001);
      EXPECT_LT(sweep.stamp, exposure);
      EXPECT_LT(exposure, sweep.stamp + sweep.span);
      // A return ahead is measured when the lidar faces forward, 3 ms before the exposure, up to
      // the 9 deg by which its laser points aside.
      for (size_t i = 0; i < sweep.size(); i += 101) {
        if (std::abs(sweep.y[i]) > 0.01F * sweep.x[i]) continue;
        EXPECT_NEAR(to_seconds(sweep.stamp + Duration(sweep.time_offset_ns[i]) - exposure), -3e-3,
                    2.8e-3);
      }
      ++sweeps;
    }
  }
  EXPECT_EQ(sweeps, 51u);
  EXPECT_EQ(speeds, 447u);
}

// A synthetic raw recording of two frames.
class RawLayout : public ::testing::Test {
 protected:
  static std::string png(uint32_t width, uint32_t height) {
    std::string bytes("\x89PNG\r\n\x1A\n\0\0\0\rIHDR", 16);
    for (const uint32_t value : {width, height}) {
      for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift);
    }
    return bytes;
  }

  void SetUp() override {
    const std::string drive = "day/2011_09_26_drive_0001_sync/";
    folder_.write("day/calib_cam_to_cam.txt",
                  "calib_time: 09-Jan-2012 13:57:47\ncorner_dist: 9.95e-02\n"
                  "R_rect_00: 1 0 0 0 1 0 0 0 1\n"
                  "P_rect_00: 700 0 600 0 0 700 180 0 0 0 1 0\n"
                  "P_rect_03: 700 0 600 -350 0 700 180 0 0 0 1 0\n");
    folder_.write("day/calib_velo_to_cam.txt", "R: 0 -1 0 0 0 -1 1 0 0\nT: 0 -0.08 -0.27\n");
    folder_.write("day/calib_imu_to_velo.txt", "R: 1 0 0 0 1 0 0 0 1\nT: -0.81 0.32 -0.8\n");
    const std::string stamps = "2011-09-26 13:02:25.5\n2011-09-26 13:02:25.964389445\n";
    for (const char* stream : {"velodyne_points", "image_03", "oxts"}) {
      folder_.write(drive + stream + "/timestamps.txt", stamps);
    }
    folder_.write(drive + "velodyne_points/timestamps_start.txt",
                  "2011-09-26 13:02:25.45\n2011-09-26 13:02:25.914389445\n");
    folder_.write(drive + "velodyne_points/timestamps_end.txt",
                  "2011-09-26 13:02:25.55\n2011-09-26 13:02:26.014389445\n");
    folder_.write(drive + "velodyne_points/data/0000000001.bin", std::string(16, '\0'));
    folder_.write(drive + "image_03/data/0000000000.png", png(1242, 375));
    folder_.write(drive + "image_03/data/0000000001.png", png(1242, 375));
    // 49°N 8°E, heading 90° (north), 10 m/s north.
    const std::string rest =
        " 10 0 10 0 0 0.1 0.2 9.8 0 0 0 0.01 0.02 0.03 0 0 0 0.5 0.1 4 8 4 4 0\n";
    folder_.write(drive + "oxts/data/0000000000.txt", "49 8 110 0 0 1.5707963267948966" + rest);
    folder_.write(drive + "oxts/data/0000000001.txt",
                  "49.0001 8 110 0 0 1.5707963267948966" + rest);
    raw_ = folder_ / drive;
  }

  ScratchFolder folder_;
  std::filesystem::path raw_;
};

TEST_F(RawLayout, IsImportedWithItsStamps) {
  const auto result = import_kitti(raw_, folder_ / "drive");
  ASSERT_TRUE(result) << result.error().message();
  EXPECT_EQ(result->layout, KittiLayout::kRaw);
  EXPECT_TRUE(result->times_trusted);
  EXPECT_EQ(result->sweeps, 1u);
  EXPECT_EQ(result->images, 2u);
  EXPECT_EQ(result->poses, 2u);
  const auto drive = recording::Drive::open(folder_ / "drive");
  ASSERT_TRUE(drive) << drive.error().message();

  // The lidar's only sweep is frame 1, with its middle at 13:02:25.964389445 UTC (1317042145 s).
  const auto sweeps = recording::index_sweeps(drive->resolve("sweeps"));
  ASSERT_TRUE(sweeps);
  EXPECT_EQ(sweeps->entries.at(0).stamp.ns(), 1'317'042'145'914'389'445);
  EXPECT_EQ(sweeps->entries.at(0).span.count(), 100'000'000);
  EXPECT_EQ(drive->description.lidars[0].turn, recording::Turn());
  // Camera 3 is half a metre to the right of camera 0: coordinates in its frame are shifted by −0.5
  // m.
  const Eigen::Vector3d ahead =
      drive->description.rig.cameras.at(0).T_camera_lidar * Eigen::Vector3d(10, 1, 0.5);
  EXPECT_LT((ahead - Eigen::Vector3d(-1 - 0.5, -0.5 - 0.08, 10 - 0.27)).norm(), 1e-12);

  const auto poses = recording::read_trajectory(drive->resolve(drive->description.truth_poses));
  ASSERT_TRUE(poses);
  const Eigen::Isometry3d moved = poses->at(0).T_frame_body.inverse() * poses->at(1).T_frame_body;
  EXPECT_NEAR(moved.translation().x(), 11.12, 0.01);  // 0.0001° of latitude, straight ahead
  EXPECT_NEAR(moved.translation().y(), 0, 1e-3);
  // The vehicle's x axis points north; its origin is behind the unit and 0.93 m below it.
  EXPECT_NEAR(poses->at(0).T_frame_body.linear()(1, 0), 1, 1e-9);
  EXPECT_NEAR(poses->at(0).T_frame_body.translation().z(), -0.93, 1e-9);

  auto imu = recording::ImuCsv::open(drive->resolve("imu.csv"));
  ASSERT_TRUE(imu);
  ImuSample sample;
  ASSERT_TRUE(imu->next(sample));
  EXPECT_EQ(sample.angular_velocity, (std::array<double, 3>{0.01, 0.02, 0.03}));
  EXPECT_EQ(sample.linear_acceleration, (std::array<double, 3>{0.1, 0.2, 9.8}));
  auto fixes = gnss::GnssCsv::open(drive->resolve("gnss.csv"));
  ASSERT_TRUE(fixes);
  GnssFix fix;
  ASSERT_TRUE(fixes->next(fix));
  EXPECT_EQ(fix.speed, 10);
  EXPECT_NEAR(fix.course, 0, 1e-12);
}

TEST_F(RawLayout, ErrorsNameWhatIsMissing) {
  EXPECT_THAT(import_kitti(folder_ / "day", folder_ / "drive").error().message(),
              AllOf(HasSubstr("has none of KITTI's layouts"),
                    HasSubstr("a recording is in " + raw_.parent_path().string())));
  EXPECT_FALSE(import_kitti(folder_ / "nowhere", folder_ / "drive"));
  folder_.write("full/file", "x");
  EXPECT_THAT(import_kitti(raw_, folder_ / "full").error().message(),
              HasSubstr("exists and is not empty"));
  folder_.write("day/calib_velo_to_cam.txt", "R: 0 -1 0 0 0 -1 1 0 0\n");
  EXPECT_THAT(import_kitti(raw_, folder_ / "drive").error().message(),
              HasSubstr("calib_velo_to_cam.txt: has no T"));
  folder_.write("day/calib_velo_to_cam.txt", "R: 0 -1 0 0 0 -1 1 0 1\nT: 0 0 0\n");
  EXPECT_THAT(import_kitti(raw_, folder_ / "drive").error().message(),
              HasSubstr("R is not a rigid motion"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "drive"));
}

TEST_F(RawLayout, ReportsInvalidStampsAndImagesOfAnotherSize) {
  folder_.write("day/2011_09_26_drive_0001_sync/image_03/data/0000000001.png", png(640, 480));
  const auto result = import_kitti(raw_, folder_ / "drive");
  ASSERT_TRUE(result);
  EXPECT_EQ(result->images, 1u);
  EXPECT_THAT(text_of(result->notes), HasSubstr("a different size"));
  folder_.write("day/2011_09_26_drive_0001_sync/oxts/timestamps.txt", "2011-13-26 13:02:25.5\n");
  EXPECT_THAT(import_kitti(raw_, folder_ / "drive2").error().message(),
              HasSubstr("timestamps.txt:1: is not a time"));
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
