#include "drivers/recording/speed_csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/scratch_folder.hpp"

namespace infuse::recording {
namespace {

TEST(SpeedCsv, WriteAndReadRoundTrip) {
  const ScratchFolder folder;
  WheelOdometry a, b;
  a.stamp = Stamp::from_ns(1'000);
  a.speed = 10.25;
  b.stamp = Stamp::from_ns(2'000);
  b.speed = -0.5;
  ASSERT_TRUE(write_speed_csv(folder / "speed.csv", {a, b}));
  auto csv = SpeedCsv::open(folder / "speed.csv");
  ASSERT_TRUE(csv) << csv.error().message();
  WheelOdometry read;
  ASSERT_TRUE(csv->next(read));
  EXPECT_EQ(read.stamp, a.stamp);
  EXPECT_EQ(read.speed, 10.25);
  EXPECT_TRUE(std::isnan(read.wheel_speed[0]));
  EXPECT_TRUE(std::isnan(read.yaw_rate));
  ASSERT_TRUE(csv->next(read));
  EXPECT_EQ(read.speed, -0.5);
  EXPECT_FALSE(csv->next(read));
}

TEST(SpeedCsv, YawRatesAreWrittenWhereAskedFor) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const ScratchFolder folder;
  WheelOdometry both, speed_only, yaw_only;
  both.speed = 3;
  both.yaw_rate = -0.125;
  speed_only.speed = 4;
  speed_only.yaw_rate = yaw_only.speed = kNan;
  yaw_only.yaw_rate = 0.5;
  ASSERT_TRUE(write_speed_csv(folder / "speed.csv", {both, speed_only, yaw_only}, true));
  auto csv = SpeedCsv::open(folder / "speed.csv");
  ASSERT_TRUE(csv);
  WheelOdometry read;
  ASSERT_TRUE(csv->next(read));
  EXPECT_EQ(read.speed, 3);
  EXPECT_EQ(read.yaw_rate, -0.125);
  ASSERT_TRUE(csv->next(read));
  EXPECT_EQ(read.speed, 4);
  EXPECT_TRUE(std::isnan(read.yaw_rate));
  ASSERT_TRUE(csv->next(read));
  EXPECT_TRUE(std::isnan(read.speed));
  EXPECT_EQ(read.yaw_rate, 0.5);
  EXPECT_FALSE(csv->next(read));
}

TEST(SpeedCsv, SkipsAndNotesRowsThatAreNotNumbers) {
  const ScratchFolder folder;
  folder.write("speed.csv", "stamp_ns,speed\n1,fast\n2,3\n");
  auto csv = SpeedCsv::open(folder / "speed.csv");
  ASSERT_TRUE(csv);
  WheelOdometry read;
  ASSERT_TRUE(csv->next(read));
  EXPECT_EQ(read.stamp.ns(), 2);
  std::vector<Error> notes;
  csv->append_notes(notes);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_THAT(notes[0].message(), ::testing::HasSubstr("speed.csv:2"));
  EXPECT_FALSE(SpeedCsv::open(folder / "missing.csv"));
}

}  // namespace
}  // namespace infuse::recording
