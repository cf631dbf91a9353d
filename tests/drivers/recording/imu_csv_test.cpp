#include "drivers/recording/imu_csv.hpp"

#include <gtest/gtest.h>

#include "tests/scratch_folder.hpp"

namespace infuse::recording {
namespace {

TEST(ImuCsv, WriteAndReadRoundTrip) {
  const ScratchFolder folder;
  const ImuSample imu{Stamp::from_ns(5), {0.1, -0.2, 1e-9}, {1.0 / 3, 0, 9.81}};
  ASSERT_TRUE(write_imu_csv(folder / "imu.csv", {imu}));
  auto imu_csv = ImuCsv::open(folder / "imu.csv");
  ASSERT_TRUE(imu_csv);
  ImuSample imu_back;
  ASSERT_TRUE(imu_csv->next(imu_back));
  EXPECT_EQ(imu_back.stamp, imu.stamp);
  EXPECT_EQ(imu_back.angular_velocity, imu.angular_velocity);
  EXPECT_EQ(imu_back.linear_acceleration, imu.linear_acceleration);
  EXPECT_FALSE(imu_csv->next(imu_back));
}

}  // namespace
}  // namespace infuse::recording
