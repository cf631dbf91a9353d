#include "daemon/calibration/saved_calibrations.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <fstream>
#include <random>

namespace infuse::daemon {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class SavedCalibrationsTest : public testing::Test {
 protected:
  SavedCalibrationsTest() { std::filesystem::create_directories(folder_); }
  ~SavedCalibrationsTest() override { std::filesystem::remove_all(folder_); }

  static Rig rig(double x) {
    Rig rig;
    rig.lidars.push_back({.name = "top"});
    rig.cameras.push_back({.name = "front", .lidar = "top"});
    rig.cameras.push_back({.name = "rear", .lidar = "top"});
    rig.cameras[0].T_camera_lidar.translation().x() = x;
    return rig;
  }

  static CalibrationReport report(double x) {
    CalibrationReport report;
    report.camera = "front";
    report.stamp = Stamp::from_ns(42);
    report.T_camera_lidar.translation().x() = x;
    return report;
  }

  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("infuse-saved-" + std::to_string(::getpid()));
  std::filesystem::path path_ = folder_ / "calibrations.json";
};

TEST_F(SavedCalibrationsTest, AnAppliedCalibrationIsInUseAfterARestart) {
  Rig first = rig(0.1);
  SavedCalibrations saved(path_);
  EXPECT_TRUE(saved.restore(first).empty());
  ASSERT_TRUE(saved.save(report(0.1)));
  EXPECT_FALSE(std::filesystem::exists(path_));  // nothing has changed
  ASSERT_TRUE(saved.save(report(0.15)));

  Rig second = rig(0.1);
  const auto lines = SavedCalibrations(path_).restore(second);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_THAT(lines[0], HasSubstr("front"));
  EXPECT_EQ(second.cameras[0].T_camera_lidar.translation().x(), 0.15);
  EXPECT_EQ(second.cameras[1].T_camera_lidar.translation().x(), 0);

  // A rollback to the configured calibration is saved too.
  SavedCalibrations again(path_);
  Rig third = rig(0.1);
  again.restore(third);
  ASSERT_TRUE(again.save(report(0.1)));
  Rig fourth = rig(0.1);
  SavedCalibrations(path_).restore(fourth);
  EXPECT_EQ(fourth.cameras[0].T_camera_lidar.translation().x(), 0.1);
}

TEST_F(SavedCalibrationsTest, WhatCouldNotBeWrittenIsWrittenLater) {
  Rig first = rig(0.1);
  SavedCalibrations saved(path_);
  saved.restore(first);
  std::filesystem::remove_all(folder_);
  std::ofstream(folder_) << "a file in place of the folder";
  EXPECT_FALSE(saved.save(report(0.15)));
  EXPECT_FALSE(saved.save_frozen("rear", true));
  EXPECT_FALSE(saved.save_frozen("rear", true));  // still not in the file
  std::filesystem::remove(folder_);
  EXPECT_TRUE(saved.save(report(0.15)));  // the same calibration again

  Rig second = rig(0.1);
  SavedCalibrations again(path_);
  again.restore(second);
  EXPECT_EQ(second.cameras[0].T_camera_lidar.translation().x(), 0.15);
  EXPECT_THAT(again.frozen_cameras(), ElementsAre("rear"));
}

TEST_F(SavedCalibrationsTest, AFrozenCalibrationIsFrozenAfterARestart) {
  Rig first = rig(0.1);
  SavedCalibrations saved(path_);
  saved.restore(first);
  ASSERT_TRUE(saved.save_frozen("front", true));  // before any image
  ASSERT_TRUE(saved.save(report(0.1)));           // an image from before the request

  Rig second = rig(0.1);
  SavedCalibrations again(path_);
  EXPECT_THAT(again.restore(second), ElementsAre(HasSubstr("frozen")));
  EXPECT_THAT(again.frozen_cameras(), ElementsAre("front"));
  ASSERT_TRUE(again.save_frozen("", false));

  Rig third = rig(0.1);
  SavedCalibrations last(path_);
  EXPECT_TRUE(last.restore(third).empty());
  EXPECT_TRUE(last.frozen_cameras().empty());
}

TEST_F(SavedCalibrationsTest, AFileWithoutFrozenIsRead) {
  std::string text = format_calibrations({{.camera = "front", .frozen = true}});
  const size_t line = text.find("      \"frozen\"");
  ASSERT_NE(line, std::string::npos);
  text.replace(line, text.find('\n', line) + 1 - line, "");
  const auto read = parse_calibrations(text);
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->at(0).camera, "front");
  EXPECT_FALSE(read->at(0).frozen);
}

TEST_F(SavedCalibrationsTest, AFileOfAnotherReleaseIsKeptAndNamed) {
  const std::string newer = "{\"form\": 2, \"cameras\": []}\n";
  std::ofstream(path_) << newer;
  Rig first = rig(0.1);
  SavedCalibrations saved(path_);
  saved.restore(first);
  ASSERT_TRUE(saved.damage());
  EXPECT_THAT(*saved.damage(), HasSubstr("not a calibration file of this release"));
  ASSERT_TRUE(saved.save(report(0.2)));
  std::ifstream kept(path_.string() + ".unreadable");
  EXPECT_EQ((std::string{std::istreambuf_iterator<char>(kept), {}}), newer);
  Rig second = rig(0.1);
  SavedCalibrations again(path_);
  again.restore(second);
  EXPECT_FALSE(again.damage());
}

TEST_F(SavedCalibrationsTest, AChangedConfigurationTakesPrecedence) {
  Rig first = rig(0.1);
  SavedCalibrations saved(path_);
  saved.restore(first);
  ASSERT_TRUE(saved.save(report(0.15)));
  Rig other = rig(0.3);
  EXPECT_THAT(SavedCalibrations(path_).restore(other).at(0),
              HasSubstr("configured calibration, which has changed"));
  EXPECT_EQ(other.cameras[0].T_camera_lidar.translation().x(), 0.3);
}

TEST_F(SavedCalibrationsTest, DamagedFilesAreReportedAndLeaveTheConfiguration) {
  Rig first = rig(0.1);
  SavedCalibrations saved(path_);
  saved.restore(first);
  ASSERT_TRUE(saved.save(report(0.15)));
  std::ifstream file(path_);
  const std::string whole{std::istreambuf_iterator<char>(file), {}};
  std::mt19937 random(1);
  for (int i = 0; i < 300; ++i) {
    std::string text = whole.substr(0, random() % whole.size());
    if (i % 2 == 1) {
      text = whole;
      text[random() % text.size()] = static_cast<char>(random());
    }
    std::ofstream(path_) << text;
    Rig rig = this->rig(0.1);
    SavedCalibrations(path_).restore(rig);
    const Eigen::Isometry3d& T = rig.cameras[0].T_camera_lidar;
    ASSERT_NEAR((T.linear() * T.linear().transpose() - Eigen::Matrix3d::Identity()).norm(), 0,
                1e-6);
    ASSERT_TRUE(T.translation().allFinite());
  }
}

}  // namespace
}  // namespace infuse::daemon
