#include "drivers/import/ford_import.hpp"

#include <gtest/gtest.h>

#include <random>

#include "drivers/camera/image_decoder.hpp"
#include "drivers/import/ford_files.hpp"
#include "drivers/import/ford_frames.hpp"
#include "drivers/recording/capture_reader.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/recording/speed_csv.hpp"
#include "drivers/recording/times_csv.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "drivers/text/text_file.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"
#include "fixtures/scene/capture.hpp"
#include "tests/drivers/import/mat_bytes.hpp"
#include "tests/drivers/lcm/lcm_bytes.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::importers {
namespace {

constexpr double kDegree = M_PI / 180;
constexpr int64_t kStartUs = 1'260'800'000'000'000;  // December 2009

std::span<const uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

TEST(MatFile, ReadsNumbersOfEveryTypeAndStructuresCompressedOrNot) {
  const std::string plain = mat_doubles(2, 3, {1, 2, 3, 4, 5, 6}, "A");
  const std::string bytes = mat_matrix(9, 1, 3, "B", mat_element(2, "\x01\x02\xFF"));  // uint8
  const std::string small =
      mat_matrix(6, 1, 1, "C", mat_number(uint32_t{2} << 16 | 3) + mat_number(int32_t{-7}));
  const std::string structure =
      mat_structure(2, {"K", "t"},
                    mat_doubles(1, 1, {10}) + mat_doubles(3, 1, {1, 2, 3}) +
                        mat_doubles(1, 1, {20}) + mat_doubles(3, 1, {4, 5, 6}),
                    "S");
  for (const bool compressed : {false, true}) {
    std::string all;
    for (const std::string& each : {plain, bytes, small, structure})
      all += compressed ? mat_compressed(each) : each;
    const std::string file = mat_file(all);
    const auto read = read_mat(bytes_of(file), "a.mat");
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(read->at("A").at(0, 2), 5);
    EXPECT_EQ(read->at("A").at(1, 0), 2);
    EXPECT_TRUE(std::isnan(read->at("A").at(2, 0)));
    EXPECT_EQ(read->at("B").numbers, (std::vector<double>{1, 2, 255}));
    EXPECT_EQ(read->at("C").at(0, 0), -7);
    EXPECT_EQ(read->at("S").field("K", 1)->at(0, 0), 20);
    EXPECT_EQ(read->at("S").field("t", 1)->at(2, 0), 6);
    EXPECT_EQ(read->at("S").field("t", 2), nullptr);
    EXPECT_EQ(read->at("S").field("x"), nullptr);
    const auto some = read_mat(bytes_of(file), "a.mat", {"t"});
    ASSERT_TRUE(some);
    EXPECT_TRUE(some->at("A").numbers.empty());
    EXPECT_EQ(some->at("A").columns, 3u);
    EXPECT_EQ(some->at("S").field("t")->at(0, 0), 1);
    EXPECT_TRUE(some->at("S").field("K")->numbers.empty());
  }
}

TEST(MatFile, RefusesOtherFilesAndSurvivesEveryMutation) {
  EXPECT_FALSE(read_mat(bytes_of("nothing"), "a"));
  EXPECT_FALSE(read_mat(bytes_of(std::string("MATLAB 7.3 MAT-file") + std::string(600, ' ')), "a"));
  const std::string structure =
      mat_structure(1, {"K", "t"}, mat_doubles(1, 1, {10}) + mat_doubles(3, 1, {1, 2, 3}), "S");
  const std::string file = mat_file(mat_doubles(2, 2, {1, 2, 3, 4}, "A") +
                                    mat_compressed(mat_doubles(1, 1, {1}, "B")) + structure);
  ASSERT_TRUE(read_mat(bytes_of(file), "a"));
  for (size_t length = 0; length < file.size(); ++length) {
    const std::string cut = file.substr(0, length);
    static_cast<void>(read_mat(bytes_of(cut), "a"));
  }
  std::mt19937 random(1);
  for (int k = 0; k < 10'000; ++k) {
    std::string mutated = file;
    for (int n = 0; n < 1 + k % 4; ++n) {
      mutated[128 + random() % (mutated.size() - 128)] =
          static_cast<char>(random() % 4 == 0 ? 0xFF : random());
    }
    static_cast<void>(read_mat(bytes_of(mutated), "a"));
  }
}

// The table states X_bh, and the text how it follows from two others: our reading of the angles and
// their order must give it. The table is rounded and not consistent: to 6 cm and 1°.
TEST(FordFrames, TheTransformsOfTheTableAgree) {
  const Eigen::Isometry3d X_bl = ford_transform({2.4, -0.01, -2.3, 180 * kDegree, 0, 90 * kDegree});
  const Eigen::Isometry3d X_hl =
      ford_transform({0.3, -0.005, -0.426, -0.15 * kDegree, 0, -90.27 * kDegree});
  const Eigen::Isometry3d X_bh =
      ford_transform({2.06, 0.0, -2.72, -180 * kDegree, -0.02 * kDegree, -0.8 * kDegree});
  const Eigen::Isometry3d composed = X_bl * X_hl.inverse();
  EXPECT_LT(Eigen::AngleAxisd(composed.linear().transpose() * X_bh.linear()).angle(), 1 * kDegree);
  EXPECT_LT((composed.translation() - X_bh.translation()).norm(), 0.06);
}

TEST(FordFrames, TheLidarLooksForwardAndUp) {
  const Eigen::Isometry3d T = ford_T_vehicle_lidar();
  EXPECT_TRUE(T.linear().isIdentity(1e-12));
  EXPECT_TRUE(T.translation().isApprox(Eigen::Vector3d(2.4, 0.01, 2.3 + kFordAxleHeight), 1e-12));
}

TEST(FordFiles, StampsAreFoundInLinesOfAnyForm) {
  std::vector<Error> notes;
  const auto stamps = parse_ford_stamps(
      "# image, time\n1 1260800000000000\n2,1260800000125000\r\n\n1260800000250000 99\n12\n", "t",
      notes);
  ASSERT_EQ(stamps.size(), 3u);
  EXPECT_EQ(stamps[1].ns(), 1'260'800'000'125'000'000);
  EXPECT_EQ(notes.size(), 1u);  // two lines without
}

TEST(FordFiles, PnmHeadersAreBounded) {
  const std::string pixels(6, 'x');
  const auto header = read_pnm_header("P6\n# a comment\n2 1\n255\n" + pixels);
  ASSERT_TRUE(header);
  EXPECT_EQ(header->width, 2);
  EXPECT_TRUE(header->colour);
  EXPECT_FALSE(read_pnm_header("P6 2 1 255\nxxxxx"));
  EXPECT_FALSE(read_pnm_header("P6 2 1 65535\n" + pixels));
  EXPECT_FALSE(read_pnm_header("P6 99999999 1 255\n" + pixels));
  EXPECT_FALSE(read_pnm_header("P3 2 1 255\n" + pixels));
  EXPECT_FALSE(read_pnm_header("P6"));
}

/// A trial that drives a circle to the left at 5 m/s and 0.1 rad/s, as the thesis describes its
/// files. The local frame is as stated: z up, so that the body is turned upside down by its roll.
class FordImportTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(fixtures::make_capture(folder_ / "in.pcap",
                                       {.model = &velodyne::lidar_model(velodyne::Model::kHdl64eS2),
                                        .duration = Duration{300'000'000},
                                        .start = Stamp::from_ns(kStartUs * 1000)}));
    auto reader = recording::CaptureReader::open(folder_ / "in.pcap");
    ASSERT_TRUE(reader);
    std::string log;
    uint64_t number = 0;
    for (Datagram datagram; reader->next(datagram);) {
      const auto us = static_cast<uint64_t>(datagram.stamp.ns() / 1000);
      const std::string payload(datagram.payload.begin(), datagram.payload.end());
      log += lcm::make_event(number++, us + 2000, "VELODYNE", lcm::make_raw_message(us, payload));
      if (payload.size() == 1206) ++packets_;
    }
    folder_.write("trial/LCM/lcmlog", log);
    std::string stamps, param_fields;
    for (int k = 0; k < 3; ++k) stamps += std::to_string(kStartUs + k * 125'000) + "\n";
    folder_.write("trial/Timestamp.log", stamps);
    for (int camera = 0; camera < 2; ++camera) {
      for (int k = 0; k < 3; ++k) {
        std::string pixels = {static_cast<char>(10 * k), 20, 30, 40, 50, 60};
        folder_.write(
            "trial/IMAGES/Cam" + std::to_string(camera) + "/image000" + std::to_string(k) + ".ppm",
            "P6\n2 1\n255\n" + pixels);
      }
      // The camera looks forward: x right, y down, z along y of Velodyne's frame.
      param_fields += mat_doubles(3, 3, {400, 0, 0, 0, 410, 0, 300, 200, 1}) +
                      mat_doubles(3, 3, {1, 0, 0, 0, 0, 1, 0, -1, 0}) +
                      mat_doubles(3, 1, {0.1, 0.2, 0.3}) + mat_doubles(1, 1, {0});
    }
    folder_.write("trial/IMAGES/FULL/image0000.ppm", "P6\n2 1\n255\nxxxxxx");
    folder_.write("trial/PARAM.mat",
                  mat_file(mat_compressed(
                      mat_structure(2, {"K", "R", "t", "MappingMatrix"}, param_fields, "PARAM"))));
    std::vector<double> utime, pos, rph, vel;
    for (int k = 0; k <= 30; ++k) {
      const double s = 0.01 * k, yaw = 0.1 * s;
      utime.push_back(static_cast<double>(kStartUs + k * 10'000));
      for (const double v : {50 * std::sin(yaw), 50 * (1 - std::cos(yaw)), 0.4}) pos.push_back(v);
      for (const double v : {M_PI, 0.0, yaw}) rph.push_back(v);
      for (const double v : {5 * std::cos(yaw), 5 * std::sin(yaw), 0.0}) vel.push_back(v);
      if (k % 10 == 0) {
        const size_t at = pos.size() - 3;
        folder_.write(
            "trial/SCANS/Scan000" + std::to_string(k / 10) + ".mat",
            mat_file(mat_structure(
                1, {"XYZ", "timestamp_laser", "X_wv"},
                mat_doubles(3, 2, {1, 2, 3, 4, 5, 6}) + mat_doubles(1, 1, {utime.back()}) +
                    mat_doubles(6, 1, {pos[at], pos[at + 1], pos[at + 2], M_PI, 0, yaw}),
                "SCAN")));
      }
    }
    folder_.write("trial/Pose-Applanix.mat",
                  mat_file(mat_structure(1, {"utime", "pos", "rph", "vel"},
                                         mat_doubles(1, 31, utime) + mat_doubles(3, 31, pos) +
                                             mat_doubles(3, 31, rph) + mat_doubles(3, 31, vel),
                                         "Pose")));
  }

  ScratchFolder folder_;
  size_t packets_ = 0;
};

TEST_F(FordImportTest, ATrialBecomesADrive) {
  const auto imported = import_ford(folder_ / "trial", folder_ / "drive");
  ASSERT_TRUE(imported) << imported.error().message();
  EXPECT_GE(imported->packets, packets_);
  EXPECT_EQ(imported->images, 6u);
  EXPECT_EQ(imported->cameras, 2u);
  EXPECT_EQ(imported->speeds, 30u);
  EXPECT_EQ(imported->poses, 4u);
  const auto drive = recording::Drive::open(folder_ / "drive");
  ASSERT_TRUE(drive) << drive.error().message();
  const auto& rig = drive->description.rig;
  ASSERT_EQ(rig.lidars.size(), 1u);
  EXPECT_TRUE(rig.lidars[0].T_vehicle_lidar.isApprox(ford_T_vehicle_lidar(), 1e-12));
  ASSERT_EQ(rig.cameras.size(), 2u);
  EXPECT_EQ(rig.cameras[1].name, "Cam1");
  EXPECT_EQ(rig.cameras[1].intrinsics.fy, 410);
  EXPECT_EQ(rig.cameras[1].intrinsics.cx, 300);
  // A point ahead of the lidar is ahead of the camera, one to the left is to its left.
  const Eigen::Vector3d ahead = rig.cameras[0].T_camera_lidar * Eigen::Vector3d(10, 1, 2);
  EXPECT_TRUE(ahead.isApprox(Eigen::Vector3d(-1 + 0.1, -2 + 0.2, 10 + 0.3), 1e-9))
      << ahead.transpose();
  const auto image = text::read_text(folder_ / "drive/Cam1/000002.png", 1 << 20);
  ASSERT_TRUE(image);
  CameraFrame frame;
  ASSERT_TRUE(camera::decode_image(bytes_of(*image), {}, frame));
  EXPECT_EQ(frame.pixels[2], 20);  // blue, green, red
  EXPECT_EQ(frame.pixels[0], 30);
  auto speeds = recording::SpeedCsv::open(folder_ / "drive/speed.csv");
  ASSERT_TRUE(speeds);
  size_t rows = 0;
  for (WheelOdometry sample; speeds->next(sample); ++rows) {
    EXPECT_NEAR(sample.speed, 5, 1e-6);
    EXPECT_NEAR(sample.yaw_rate, 0.1, 1e-6);
  }
  EXPECT_EQ(rows, 30u);
  const auto truth = recording::parse_tum(
      text::read_text(folder_ / "drive/truth/poses.tum", 1 << 20).value_or(""), "truth");
  ASSERT_TRUE(truth);
  ASSERT_EQ(truth->size(), 4u);
  for (size_t k = 0; k < 4; ++k) {
    const double yaw = 0.01 * static_cast<double>(k);
    const Eigen::Isometry3d& T = (*truth)[k].T_frame_body;
    EXPECT_TRUE(T.linear().isApprox(
        Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix(), 1e-6));
    EXPECT_NEAR(T.translation().z(), 0, 1e-6);  // 0.4 m below the body
  }
}

TEST_F(FordImportTest, WhatIsMissingIsSaidAndTheRestTaken) {
  std::filesystem::remove(folder_ / "trial/PARAM.mat");
  std::filesystem::remove_all(folder_ / "trial/SCANS");
  folder_.write("trial/Pose-Applanix.mat", "1 2 3\n");
  const auto imported = import_ford(folder_ / "trial", folder_ / "drive");
  ASSERT_TRUE(imported) << imported.error().message();
  EXPECT_EQ(imported->images + imported->speeds + imported->poses, 0u);
  std::string notes;
  for (const Error& note : imported->notes) notes += note.message() + "\n";
  EXPECT_NE(notes.find("no images are taken"), std::string::npos) << notes;
  EXPECT_NE(notes.find("no odometry is taken"), std::string::npos) << notes;
  EXPECT_TRUE(recording::Drive::open(folder_ / "drive"));
  std::filesystem::remove_all(folder_ / "trial/LCM");
  EXPECT_FALSE(import_ford(folder_ / "trial", folder_ / "other"));
}

TEST_F(FordImportTest, StampsFollowFromTheNumbersWhereFilesAreMissing) {
  std::filesystem::remove(folder_ / "trial/IMAGES/Cam0/image0001.ppm");
  const auto imported = import_ford(folder_ / "trial", folder_ / "drive");
  ASSERT_TRUE(imported) << imported.error().message();
  EXPECT_EQ(imported->images, 5u);
  const auto times = recording::read_times(folder_ / "drive/Cam0/times.csv");
  ASSERT_TRUE(times);
  ASSERT_EQ(times->size(), 2u);
  EXPECT_EQ((*times)[1].stamp.ns(), (kStartUs + 250'000) * 1000);
}

}  // namespace
}  // namespace infuse::importers
