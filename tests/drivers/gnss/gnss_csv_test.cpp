#include "drivers/gnss/gnss_csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/scratch_folder.hpp"

namespace infuse::gnss {
namespace {

using ::testing::HasSubstr;

TEST(GnssCsv, WriteAndReadRoundTrip) {
  const ScratchFolder folder;
  GnssFix fix;
  fix.stamp = Stamp::from_ns(6);
  fix.latitude = 0.85;
  fix.longitude = -2.5;
  fix.altitude = std::nan("");
  fix.speed = 12.5;
  fix.course = 6.28;
  fix.hdop = std::nan("");
  fix.utc_ns = 77;
  fix.valid = false;
  ASSERT_TRUE(write_gnss_csv(folder / "gnss.csv", {fix}));
  auto gnss_csv = GnssCsv::open(folder / "gnss.csv");
  ASSERT_TRUE(gnss_csv);
  GnssFix back;
  ASSERT_TRUE(gnss_csv->next(back));
  EXPECT_EQ(back.stamp, fix.stamp);
  EXPECT_DOUBLE_EQ(back.latitude, fix.latitude);
  EXPECT_DOUBLE_EQ(back.longitude, fix.longitude);
  EXPECT_TRUE(std::isnan(back.altitude));
  EXPECT_EQ(back.speed, fix.speed);
  EXPECT_DOUBLE_EQ(back.course, fix.course);
  EXPECT_TRUE(std::isnan(back.hdop));
  EXPECT_EQ(back.utc_ns, 77);
  EXPECT_FALSE(back.valid);
}

TEST(GnssCsv, OptionalColumnsHaveDefaults) {
  const ScratchFolder folder;
  folder.write("gnss.csv", "longitude_deg,stamp_ns,latitude_deg\n8.4,5,49\n");
  auto csv = GnssCsv::open(folder / "gnss.csv");
  ASSERT_TRUE(csv);
  GnssFix fix;
  ASSERT_TRUE(csv->next(fix));
  EXPECT_NEAR(fix.longitude, 0.14661, 1e-5);
  EXPECT_TRUE(std::isnan(fix.altitude));
  EXPECT_TRUE(fix.valid);
}

TEST(GnssCsv, SkipsAndNotesInvalidRows) {
  const ScratchFolder folder;
  folder.write("gnss.csv", "stamp_ns,latitude_deg,longitude_deg\n1,91,0\n2,x,0\n3,45,90\n");
  auto csv = GnssCsv::open(folder / "gnss.csv");
  ASSERT_TRUE(csv);
  GnssFix fix;
  ASSERT_TRUE(csv->next(fix));
  EXPECT_EQ(fix.stamp.ns(), 3);
  EXPECT_FALSE(csv->next(fix));
  std::vector<Error> notes;
  csv->append_notes(notes);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_THAT(notes[0].message(), HasSubstr("gnss.csv:2: "));
  EXPECT_THAT(notes[0].message(), HasSubstr("2 such lines were skipped"));
}

TEST(GnssCsv, RequiresStampLatitudeAndLongitude) {
  const ScratchFolder folder;
  folder.write("gnss.csv", "stamp_ns,latitude_deg\n1,45\n");
  EXPECT_THAT(GnssCsv::open(folder / "gnss.csv").error().message(),
              HasSubstr("has no column 'longitude_deg'"));
}

}  // namespace
}  // namespace infuse::gnss
