#include "daemon/tools/export/mcap_export.hpp"

#include <gtest/gtest.h>

#include "daemon/ros/report_messages.hpp"
#include "drivers/gnss/gnss_csv.hpp"
#include "drivers/import/bag.hpp"
#include "drivers/recording/drive_source.hpp"
#include "drivers/recording/imu_csv.hpp"
#include "drivers/recording/speed_csv.hpp"
#include "tests/daemon/tools/export/exported_drive.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

TEST(McapExport, RecoveredFileHasTheMessagesOfTheCutOne) {
  const ScratchFolder folder;
  write_drive(folder / "drive");
  const auto whole = export_mcap(folder / "drive", folder / "a.mcap", {});
  ASSERT_TRUE(whole);
  const std::string bytes = folder.read("a.mcap");
  folder.write("cut.mcap", bytes.substr(0, bytes.size() * 9 / 10));
  const auto recovered = recover_mcap(folder / "cut.mcap", folder / "whole.mcap");
  ASSERT_TRUE(recovered) << recovered.error().message();
  EXPECT_EQ(recovered->notes.size(), 1u);
  EXPECT_FALSE(recover_mcap(folder / "cut.mcap", folder / "cut.mcap"));
  EXPECT_FALSE(recover_mcap(folder / "drive/drive.toml", folder / "b.mcap"));
  const auto bag = importers::open_bag(folder / "whole.mcap");
  ASSERT_TRUE(bag);
  std::map<std::string, size_t> messages;
  importers::BagMessage message;
  while ((*bag)->next(message)) ++messages[std::string(message.topic)];
  EXPECT_EQ(messages, recovered->messages);
  std::vector<Error> notes;
  (*bag)->append_notes(notes);
  EXPECT_TRUE(notes.empty());
}

TEST(McapExport, ReportsBecomePosesAndDiagnostics) {
  const ScratchFolder folder;
  write_drive(folder / "drive");
  std::string covariance = "1e-4";
  for (int k = 1; k < 36; ++k) covariance += k % 7 == 0 ? ",1e-4" : ",0";
  const std::string pose =
      R"(,"T_frame_vehicle":[1,0,0,5,0,1,0,6,0,0,1,0,0,0,0,1],"covariance":[)" + covariance +
      R"(],"speed":3,"yaw_rate":0.1})";
  folder.write(
      "reports.jsonl",
      R"({"class":"VERSION"})"
      "\n" +
          (R"({"class":"POSE","stamp":1700000600000000000,"frame":"odom","usable":true)" + pose) +
          "\n" +
          (R"({"class":"POSE","stamp":1700000600000000001,"frame":"map","usable":false)" + pose) +
          "\n"
          R"({"class":"ALERT","stamp":1700000600000000002,"id":"a","device":"top",)"
          R"("severity":"WARN","state":"raised","since":1,"what":"w","advice":"d"})"
          "\nnot a report\n");
  const auto exported =
      export_mcap(folder / "drive", folder / "a.mcap", {.reports = folder / "reports.jsonl"});
  ASSERT_TRUE(exported) << exported.error().message();
  EXPECT_EQ(exported->messages.at("/odometry/odom"), 1u);
  EXPECT_EQ(exported->messages.at("/tf"), 1u);
  EXPECT_EQ(exported->messages.at("/diagnostics"), 1u);
  EXPECT_FALSE(exported->messages.contains("/odometry/map"));
  ASSERT_EQ(exported->notes.size(), 1u);
  EXPECT_EQ(exported->notes[0].what, "1 lines are not reports");
}

// Sampled: perturb a pose as the covariance says, and look how far the vehicle moves.
TEST(McapExport, CovarianceIsThatOfTheVehiclesPosition) {
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  covariance(2, 2) = 1e-6;  // 1 mrad of heading about the origin of the frame
  covariance(3, 3) = 1e-4;
  const auto result = to_ros_covariance(covariance, {100, 0, 0});
  EXPECT_NEAR(result[0 * 6 + 0], 1e-4, 1e-12);
  EXPECT_NEAR(result[1 * 6 + 1], 1e-2, 1e-12);  // 0.1 m to the side at 100 m
  EXPECT_NEAR(result[1 * 6 + 5], 1e-4, 1e-12);  // left with a turn to the left
  EXPECT_NEAR(result[5 * 6 + 5], 1e-6, 1e-12);
}

TEST(McapExport, WhatCannotBeReadOrWrittenIsAnError) {
  const ScratchFolder folder;
  write_drive(folder / "drive");
  EXPECT_FALSE(export_mcap(folder / "none", folder / "a.mcap", {}));
  EXPECT_FALSE(export_mcap(folder / "drive", folder / "none/a.mcap", {}));
  EXPECT_FALSE(export_mcap(folder / "drive", folder / "a.mcap", {.reports = folder / "none"}));
}

}  // namespace
}  // namespace infuse::daemon
