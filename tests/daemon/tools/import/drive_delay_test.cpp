#include "daemon/tools/import/drive_delay.hpp"

#include <gtest/gtest.h>

#include <iostream>

#include "drivers/import/kitti_import.hpp"
#include "drivers/recording/drive.hpp"
#include "tests/real_data.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

// The rates of the unit lag by 60 to 80 ms: heading over whole drives of that car, integrated. A
// second run, which sees the corrected stamps, finds the same.
TEST(DriveDelay, IsWrittenForARealDrive) {
  INFUSE_REAL_DATA_OR_SKIP(path, "drives/kitti_raw_0009/2011_09_26/2011_09_26_drive_0009_sync");
  const ScratchFolder folder;
  auto imported = importers::import_kitti(path, folder / "drive");
  ASSERT_TRUE(imported) << imported.error().message();
  find_inertial_delay(folder / "drive", imported->notes);
  const auto drive = recording::Drive::open(folder / "drive");
  ASSERT_TRUE(drive) << drive.error().message();
  std::cout << imported->notes.back().message() << "\n";
  EXPECT_NEAR(to_seconds(drive->description.imu_delay), 0.070, 0.015);
  EXPECT_GT(to_seconds(drive->description.imu_delay_sigma), 0.001);
  EXPECT_LT(to_seconds(drive->description.imu_delay_sigma), 0.015);
  find_inertial_delay(folder / "drive", imported->notes);
  const auto again = recording::Drive::open(folder / "drive");
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_NEAR(to_seconds(again->description.imu_delay), to_seconds(drive->description.imu_delay),
              0.001);
}

}  // namespace
}  // namespace infuse::daemon
