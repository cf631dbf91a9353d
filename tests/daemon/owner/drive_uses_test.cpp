#include "daemon/owner/drive_uses.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace infuse::daemon {
namespace {

using ::testing::HasSubstr;

Summary complete() {
  Summary summary;
  for (const SensorKind kind : {SensorKind::kLidar, SensorKind::kCamera, SensorKind::kGnss})
    summary.sensors.push_back({{kind, 0}, {}});
  summary.has_odometry = true;
  summary.totals.sweeps = summary.totals.frames = summary.totals.matched_frames = 51;
  summary.totals.deskewed_sweeps = 50;
  summary.totals.deskew_reason = "begins later";
  return summary;
}

TEST(DriveUses, OfACompleteDrive) {
  const auto uses = drive_uses(complete(), true);
  ASSERT_EQ(uses.size(), 4u);
  for (const DriveUse& use : uses) EXPECT_STREQ(answer(use), "yes") << use.use;
  EXPECT_EQ(uses[0].statement, "50 of 51 sweeps; others: begins later");
  EXPECT_THAT(uses[3].statement, HasSubstr("GNSS"));
}

TEST(DriveUses, SayWhatIsMissing) {
  Summary summary = complete();
  summary.has_odometry = false;
  summary.totals.deskewed_sweeps = 0;
  summary.totals.deskew_reason = "no odometry";
  const auto uses = drive_uses(summary, false);
  for (const DriveUse& use : uses) EXPECT_FALSE(use.possible) << use.use;
  EXPECT_THAT(uses[0].statement, HasSubstr("add wheel speeds"));
  EXPECT_EQ(uses[2].statement, "no sweep is deskewed");
  EXPECT_STREQ(answer(uses[2]), "only if the vehicle stood still");
  EXPECT_STREQ(answer(uses[3]), "no");
  EXPECT_THAT(uses[3].statement, HasSubstr("missing: odometry, a street map"));
}

// As of a drive with synthetic times, in which the lidar measures the motion all the same.
TEST(DriveUses, OdometryWithoutDeskewedSweepsIsNotMissing) {
  Summary summary = complete();
  summary.totals.deskewed_sweeps = 0;
  const auto uses = drive_uses(summary, true);
  EXPECT_FALSE(uses[3].possible);
  EXPECT_EQ(uses[3].statement, "missing: deskewed sweeps");
}

TEST(DriveUses, NeedImagesNearSweeps) {
  Summary summary = complete();
  summary.totals.matched_frames = 1;
  EXPECT_THAT(drive_uses(summary, true)[1].statement, HasSubstr("1 of 51 images"));
  summary.sensors.erase(summary.sensors.begin() + 1);
  EXPECT_EQ(drive_uses(summary, true)[1].statement, "there is no camera");
}

}  // namespace
}  // namespace infuse::daemon
