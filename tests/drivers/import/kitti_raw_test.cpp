#include "drivers/import/kitti_import.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "drivers/gnss/gnss_csv.hpp"
#include "drivers/recording/drive_source.hpp"
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

}  // namespace
}  // namespace infuse::importers
