#include "daemon/view/view_frames.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <thread>

#include "daemon/pipeline/latest_value.hpp"
#include "tests/daemon/view/small_sweep.hpp"

namespace infuse::daemon {
namespace {

TEST(ViewFrames, SweepsAreQuantisedToCentimetres) {
  const SmallSweep small(5);
  ViewTap tap(0);
  tap.add_sweep(small.snapshot(), nullptr);
  ViewSweep out;
  EXPECT_FALSE(tap.swap_sweep(out));  // nobody looked
  tap.set_wanted(true);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation().x() = 7;
  tap.add_sweep(small.snapshot(), &T);
  ASSERT_TRUE(tap.swap_sweep(out));
  const Frame frame(encode_sweep(out, small_rig()));
  EXPECT_EQ(frame.payload % 8, 0u);
  EXPECT_EQ(frame.header["kind"], "sweep");
  EXPECT_EQ(frame.header["device"], "top");
  EXPECT_EQ(frame.header["stamp"], "1700000000123456789");
  EXPECT_EQ(frame.header["T_vehicle_lidar"][3], 0.5);
  EXPECT_EQ(frame.header["T_odom_vehicle"][3], 7.0);
  ASSERT_EQ(frame.points(), 5u);
  EXPECT_EQ(frame.bytes.size(), frame.payload + 8 * 5);
  for (size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(frame.coordinate(0, i), 10 * static_cast<int>(i));
    EXPECT_EQ(frame.coordinate(1, i), -10 * static_cast<int>(i));
    EXPECT_EQ(frame.coordinate(2, i), 10);
    EXPECT_EQ(frame.reflectivity(i), i % 2 == 0 ? 0 : 255);
  }
  EXPECT_FALSE(tap.swap_sweep(out));  // taken
}

TEST(LatestValue, TheNewestIsNeverLeftOutAndNoneIsSeenTwice) {
  constexpr int kCount = 200'000;
  LatestValue<std::array<int, 8>> latest;
  std::array<int, 8> out{};
  EXPECT_FALSE(latest.take(out));
  std::jthread writer([&] {
    for (int k = 1; k <= kCount; ++k) {
      latest.next().fill(k);
      latest.publish();
    }
  });
  for (int seen = 0; seen < kCount;) {
    if (!latest.take(out)) continue;
    ASSERT_GT(out[0], seen);
    ASSERT_THAT(out, testing::Each(out[0]));
    seen = out[0];
  }
  EXPECT_FALSE(latest.take(out));
}

TEST(ViewFrames, SweepsCarryThePlaceOnTheMap) {
  ViewTap tap(0);
  tap.set_wanted(true);
  ViewMapPose pose;
  pose.T_map_vehicle.translation() = Eigen::Vector3d(100, 200, 0);
  pose.covariance << 4, 1, 1, 9;
  pose.particles = {{1.04F, 2.06F}, {-3, 4}};
  tap.add_sweep(SmallSweep(3).snapshot(), nullptr, &pose);
  ViewSweep out;
  ASSERT_TRUE(tap.swap_sweep(out));
  const Frame frame(encode_sweep(out, small_rig()));
  EXPECT_EQ(frame.header["T_map_vehicle"][7], 200.0);
  EXPECT_EQ(frame.header["covariance_map"], Json({4.0, 1.0, 9.0}));
  EXPECT_EQ(frame.header["particles"], Json({1.0, 2.1, -3.0, 4.0}));
}

TEST(ViewFrames, TheStreetMapIsSentAroundAPoint) {
  using streetmap::SegmentMap;
  const streetmap::MapFrame place{.cell_size = 0.2, .min_corner = {1000, 2000}};
  streetmap::SegmentMapWriter writer(place, 1, 1);
  std::vector<uint32_t> ids(SegmentMap::kTileSize * SegmentMap::kTileSize, 0);
  ids[10 * SegmentMap::kTileSize + 30] = 1;  // row 10, column 30: 0.2 m around (1006.1, 2002.1)
  writer.set_tile(0, 0,
                  std::span<const uint32_t, SegmentMap::kTileSize * SegmentMap::kTileSize>(
                      ids.data(), ids.size()));
  const std::vector<streetmap::Segment> segments{{}, {streetmap::SegmentKind::kBuilding, 7}};
  const auto bytes = writer.finish(segments, "test");
  ASSERT_TRUE(bytes);
  const auto map = SegmentMap::open(*bytes, "test");
  ASSERT_TRUE(map) << map.error().message();
  // The middle of a cell of the message falls on that cell of the map.
  const Frame frame(encode_map(*map, {1006.1 - 0.25, 2002.1 - 0.25}, Stamp::from_ns(5)));
  EXPECT_EQ(frame.header["kind"], "map");
  EXPECT_FALSE(frame.header.contains("origin_deg"));  // not georeferenced
  const int columns = frame.header["columns"], rows = frame.header["rows"];
  ASSERT_EQ(frame.bytes.size() - frame.payload, static_cast<size_t>(columns * rows));
  for (int i = 0; i < columns * rows; ++i) {
    const double x = frame.header["x"].get<double>() + 0.5 * (i % columns + 0.5);
    const double y = frame.header["y"].get<double>() + 0.5 * (i / columns + 0.5);
    const bool there = std::abs(x - 1006.1) < 0.1 && std::abs(y - 2002.1) < 0.1;
    ASSERT_EQ(frame.bytes[frame.payload + static_cast<size_t>(i)], there ? 9 : 0) << x << ' ' << y;
  }
}

TEST(ViewFrames, LargeSweepsAreThinnedAndFarReturnsClamped) {
  SmallSweep large(3 * ViewTap::kMaxPoints + 1);
  ViewPoints points;
  quantise(large.snapshot(), ViewTap::kMaxPoints, points);
  EXPECT_LE(points.size(), ViewTap::kMaxPoints);
  EXPECT_GT(points.size(), ViewTap::kMaxPoints / 2);
  EXPECT_EQ(points.x.back(), 32'767);
  EXPECT_EQ(points.ring.back(), 255);
  large.at.x[0] = std::numeric_limits<float>::infinity();
  quantise(large.snapshot(), ViewTap::kMaxPoints, points);
  EXPECT_EQ(points.x.front(), 32'767);
}

TEST(ViewFrames, ImagesCarryTheirModelAndAJpegFile) {
  ViewImage image{.camera = CameraIndex(0)};
  image.frame.width = 4;
  image.frame.height = 2;
  const Frame frame(encode_image(image, {0xff, 0xd8, 0xff}, small_rig()));
  EXPECT_EQ(frame.header["kind"], "image");
  EXPECT_EQ(frame.header["model"], "pinhole");
  EXPECT_EQ(frame.header["fx"], 3.0);
  EXPECT_EQ(frame.bytes.substr(frame.payload), "\xff\xd8\xff");
}

}  // namespace
}  // namespace infuse::daemon
