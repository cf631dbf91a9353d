#include "daemon/mapping/map_tables.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "daemon/mapping/cloud_file.hpp"
#include "daemon/mapping/map_image.hpp"
#include "drivers/recording/pcd_sweep.hpp"
#include "drivers/text/checksum.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

Eigen::Isometry3d posed() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(1.25, -1e-9, 1234.5678);
  T.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  return T;
}

TEST(MapTables, RestoreKeyframes) {
  std::vector<MapKeyframe> keyframes(2);
  keyframes[0].cloud_checksum = "0123456789abcdef";
  keyframes[1].keyframe = {Stamp::from_ns(1'750'000'000'123'456'789), posed(), 2.5,
                           geometry::Matrix6::Identity() / 3};
  keyframes[1].points = 77;
  const std::string text = format_keyframes(keyframes);
  const auto parsed = parse_keyframes(text, "k.csv");
  ASSERT_TRUE(parsed) << parsed.error().message();
  ASSERT_EQ(parsed->size(), 2U);
  const mapping::Keyframe& second = (*parsed)[1].keyframe;
  EXPECT_EQ(second.stamp.ns(), 1'750'000'000'123'456'789);
  EXPECT_LT((second.T_odom_vehicle.matrix() - posed().matrix()).norm(), 1e-12);
  EXPECT_EQ(second.covariance, keyframes[1].keyframe.covariance);
  EXPECT_EQ((*parsed)[1].points, 77U);
  EXPECT_EQ((*parsed)[0].cloud_checksum, "0123456789abcdef");
}

TEST(MapTables, NameTheLineThatIsWrong) {
  const std::string good = format_keyframes(std::vector<MapKeyframe>(1));
  const auto message = [](const std::string& text) {
    const auto parsed = parse_keyframes(text, "k.csv");
    return parsed ? std::string("none") : parsed.error().message();
  };
  EXPECT_EQ(message(good), "none");
  EXPECT_THAT(message("another header\n"), HasSubstr("k.csv:1"));
  EXPECT_THAT(message(good.substr(0, good.size() - 1)),
              HasSubstr("k.csv:2: the last line is truncated"));
  EXPECT_THAT(message(good + "1,2\n"), HasSubstr("k.csv:3"));
  EXPECT_THAT(message(good + good.substr(good.find('\n') + 1)), HasSubstr("not in order"));
  std::string more = good;
  more.insert(more.size() - 1, ",1");
  EXPECT_THAT(message(more), HasSubstr("k.csv:2"));
  std::string infinite = good;
  infinite.replace(infinite.rfind("0\n"), 1, "inf");
  EXPECT_THAT(message(infinite), HasSubstr("k.csv:2"));
}

TEST(MapTables, RestoreClosuresAndFixes) {
  mapping::Closure closure;
  closure.from = 3;
  closure.to = 90;
  closure.guessed = false;
  closure.T_from_to = posed();
  closure.reason = "the geometry leaves free: translation along x, rotation about z";
  const auto closures = parse_closures(format_closures({closure}), "c.csv");
  ASSERT_TRUE(closures) << closures.error().message();
  EXPECT_EQ(closures->front().reason, closure.reason) << "commas included";
  EXPECT_EQ(closures->front().to, 90U);
  EXPECT_FALSE(closures->front().guessed);
  closure.from = 90;
  EXPECT_FALSE(parse_closures(format_closures({closure}), "c.csv"));

  MapFix fix;
  fix.fix.latitude = 0.87;
  fix.fix.altitude = std::numeric_limits<double>::quiet_NaN();
  fix.fix.hdop = 1.5;
  fix.keyframe = 4;
  const auto fixes = parse_fixes(format_fixes({fix}), "f.csv");
  ASSERT_TRUE(fixes) << fixes.error().message();
  EXPECT_NEAR(fixes->front().fix.latitude, 0.87, 1e-15);
  EXPECT_TRUE(std::isnan(fixes->front().fix.altitude));
  EXPECT_EQ(fixes->front().fix.hdop, 1.5);
}

mapping::Submap three_points() {
  mapping::Submap cloud;
  cloud.resize(3);
  for (size_t i = 0; i < 3; ++i) {
    cloud.x[i] = static_cast<float>(i) + 0.5F;
    cloud.y[i] = -1;
    cloud.z[i] = 2.25F;
    cloud.reflectivity[i] = 0.25F * static_cast<float>(i);
  }
  return cloud;
}

// The general reader of PCD files is the witness.
TEST(CloudFile, IsReadByTheReaderOfSweeps) {
  Sweep sweep;
  const auto read = recording::parse_pcd_sweep(format_cloud_pcd(three_points()), sweep);
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_EQ(sweep.size(), 3U);
  EXPECT_EQ(*std::max_element(sweep.x.begin(), sweep.x.end()), 2.5F);
  EXPECT_EQ(*std::max_element(sweep.reflectivity.begin(), sweep.reflectivity.end()), 0.5F);
}

TEST(CloudFile, RefusesWhatIsCutOrNotFinite) {
  const std::string bytes = format_cloud_pcd(three_points());
  ASSERT_TRUE(parse_cloud_pcd(bytes, "c"));
  EXPECT_EQ(parse_cloud_pcd(bytes, "c")->z[1], 2.25F);
  for (size_t size = 0; size < bytes.size(); size += 3) {
    EXPECT_FALSE(parse_cloud_pcd(bytes.substr(0, size), "c")) << size;
  }
  mapping::Submap endless = three_points();
  endless.y[1] = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(parse_cloud_pcd(format_cloud_pcd(endless), "c"));

  const std::string compressed = compress_cloud(three_points()).value();
  EXPECT_EQ(parse_compressed_cloud(compressed, 3, "c")->z[1], 2.25F);
  EXPECT_FALSE(parse_compressed_cloud(compressed, 2, "c"));
  EXPECT_FALSE(parse_compressed_cloud(compressed, size_t{1} << 60, "c"));
  EXPECT_FALSE(parse_compressed_cloud(compressed.substr(0, compressed.size() - 1), 3, "c"));
}

// Values of the published test vectors of FNV-1a.
TEST(Checksum, IsFnv1a) {
  EXPECT_EQ(text::checksum(""), "cbf29ce484222325");
  EXPECT_EQ(text::checksum("a"), "af63dc4c8601ec8c");
  EXPECT_EQ(text::checksum("foobar"), "85944171f73967e8");
}

TEST(MapImage, ShowsTheMapFromAbove) {
  MapImage image(1.0);
  mapping::Submap cloud = three_points();
  cloud.z[0] = 0;
  cloud.z[1] = 5;
  cloud.z[2] = 9;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation().y() = 5.5;
  image.add(cloud, T);
  cloud.resize(1);
  image.add(cloud, Eigen::Isometry3d::Identity());  // at (0.5, -1), below the others
  const auto heights = image.draw(MapImageContent::kHeight);
  ASSERT_TRUE(heights) << heights.error().message();
  ASSERT_EQ(heights->image.width, 3);
  ASSERT_EQ(heights->image.height, 6);
  EXPECT_EQ(heights->image.pixels[0], 1) << "the lowest";
  EXPECT_EQ(heights->image.pixels[15], 1) << "row at y = -1";
  EXPECT_EQ(heights->image.pixels[16], 0) << "no point";
  EXPECT_GT(heights->image.pixels[2], 1);
  const auto grey = image.draw(MapImageContent::kIntensity);
  ASSERT_TRUE(grey);
  EXPECT_LT(grey->image.pixels[0], grey->image.pixels[1]);
  EXPECT_FALSE(MapImage(1.0).draw(MapImageContent::kHeight)) << "no points";
  MapImage wide(0.05);
  wide.add(three_points(), Eigen::Isometry3d::Identity());
  T.translation() = Eigen::Vector3d(1e5, 1e5, 0);
  wide.add(three_points(), T);
  EXPECT_FALSE(wide.draw(MapImageContent::kHeight)) << "too large";
}

}  // namespace
}  // namespace infuse::daemon
