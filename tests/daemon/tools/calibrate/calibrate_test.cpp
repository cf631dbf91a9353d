// `infuse calibrate` as a person runs it, on real pairs imported from KITTI's object layout.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "drivers/import/kitti_import.hpp"
#include "drivers/import/opencalib_import.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/recording/drive_toml.hpp"
#include "tests/daemon/pipeline/run_replay.hpp"
#include "tests/daemon/run_program.hpp"
#include "tests/daemon/schema.hpp"
#include "tests/folders.hpp"
#include "tests/real_data.hpp"

namespace infuse::daemon {
namespace {

using nlohmann::json;
using testing::HasSubstr;

ProgramResult calibrate(const std::string& arguments) {
  return run_shell_command(programs_folder() + "/infuse calibrate " + arguments + " 2>/dev/null");
}

TEST(CalibrateCommand, ReportsErrorsByExitCode) {
  EXPECT_EQ(calibrate("").code, 2);
  EXPECT_EQ(calibrate("/nonexistent").code, 3);
  EXPECT_EQ(calibrate("/nonexistent --measure nonsense").code, 2);
  EXPECT_EQ(calibrate("/nonexistent --scenes 0").code, 2);
}

TEST(CalibrateCommand, RealKittiPairsConvergeAndWriteARig) {
  INFUSE_REAL_DATA_OR_SKIP(kitti, "calibration/kitti");
  TemporaryFolder folder;
  const auto drive = folder / "drive";
  ASSERT_TRUE(importers::import_kitti(kitti, drive));
  const auto rig_file = folder / "rig.toml";
  const ProgramResult ran =
      calibrate(drive.string() + " --perturb 1,0.05 --seed 2 --json --report " +
                (folder / "report").string() + " -o " + rig_file.string());
  EXPECT_EQ(ran.code, 0) << ran.output;
  EXPECT_TRUE(is_result(ran.output, "calibrate"));
  const json result = json::parse(ran.output, nullptr, false);
  ASSERT_TRUE(result.is_object()) << ran.output;
  EXPECT_TRUE(result["usable"].get<bool>());
  EXPECT_EQ(result["reason"], "");
  ASSERT_EQ(result["T_camera_lidar"].size(), 16U);
  ASSERT_EQ(result["covariance"].size(), 6U);
  EXPECT_EQ(result["covariance"][5].size(), 6U);
  EXPECT_EQ(result["scenes"].size(), 17U);
  EXPECT_LT(result["error"]["rotation_deg"].get<double>(), 0.2);
  EXPECT_LT(result["error"]["translation_m"].get<double>(), 0.05);

  const auto rig = recording::read_rig(rig_file);
  ASSERT_TRUE(rig) << rig.error().message();
  const CameraMount* camera = rig->find_camera("image_2");
  ASSERT_NE(camera, nullptr);
  EXPECT_NEAR(camera->T_camera_lidar(0, 3), result["T_camera_lidar"][3].get<double>(), 1e-12);

  std::ifstream page(folder / "report/index.html");
  const std::string html{std::istreambuf_iterator<char>(page), {}};
  EXPECT_THAT(html, HasSubstr("Usable: "));
  EXPECT_LT(html.find("standard deviation"), html.find("<svg"));
  EXPECT_THAT(html, HasSubstr("data:image/png;base64,"));
}

// 30 px are 2.4°, which these pairs do not show.
TEST(CalibrateCommand, RealKittiPairsAreNotUsableWithUnknownIntrinsics) {
  INFUSE_REAL_DATA_OR_SKIP(kitti, "calibration/kitti");
  TemporaryFolder folder;
  const auto drive = folder / "drive";
  ASSERT_TRUE(importers::import_kitti(kitti, drive));
  const ProgramResult ran =
      calibrate(drive.string() + " --unknown-intrinsics --perturb 1,0.05 --seed 2 --json");
  EXPECT_EQ(ran.code, 1);
  const json result = json::parse(ran.output, nullptr, false);
  ASSERT_TRUE(result.is_object()) << ran.output;
  EXPECT_THAT(result["reason"].get<std::string>(), HasSubstr("the intrinsics are unknown"));
  EXPECT_LT(result["error"]["rotation_deg"].get<double>(), 0.2);
  const double pitch_variance = result["covariance"][0][0].get<double>();
  EXPECT_GT(std::sqrt(pitch_variance), 0.2 * kDegree);
}

TEST(CalibrateCommand, RealKittiTwoScansAreNotUsable) {
  INFUSE_REAL_DATA_OR_SKIP(kitti, "calibration/kitti");
  TemporaryFolder folder;
  const auto drive = folder / "drive";
  ASSERT_TRUE(importers::import_kitti(kitti, drive));
  const ProgramResult ran = calibrate(drive.string() + " --scenes 2 --within 0 --json");
  EXPECT_EQ(ran.code, 1);
  EXPECT_TRUE(is_result(ran.output, "calibrate"));
  const json result = json::parse(ran.output, nullptr, false);
  ASSERT_TRUE(result.is_object()) << ran.output;
  EXPECT_FALSE(result["usable"].get<bool>());
  EXPECT_NE(result["reason"], "");
}

// A pair says nothing of how far pairs disagree, so it is refused; what it says is right all the
// same.
TEST(CalibrateCommand, RealOpenCalibScenesAreNotUsableAndWithinADegree) {
  INFUSE_REAL_DATA_OR_SKIP(scenes, "calibration/opencalib");
  TemporaryFolder folder;
  for (const std::string scene : {"scene2", "scene3"}) {
    const auto drive = folder / scene;
    ASSERT_TRUE(importers::import_opencalib(scenes / (scene + ".calib.txt"), drive));
    const ProgramResult ran = calibrate(drive.string() + " --perturb 1,0.05 --seed 3 --json");
    EXPECT_EQ(ran.code, 1);
    EXPECT_TRUE(is_result(ran.output, "calibrate"));
    const json result = json::parse(ran.output, nullptr, false);
    ASSERT_TRUE(result.is_object()) << ran.output;
    EXPECT_FALSE(result["usable"].get<bool>());
    EXPECT_THAT(result["reason"].get<std::string>(), HasSubstr("at least 3 are needed"));
    EXPECT_LT(result["error"]["rotation_deg"].get<double>(), 1.0) << scene;
  }
}

}  // namespace
}  // namespace infuse::daemon
