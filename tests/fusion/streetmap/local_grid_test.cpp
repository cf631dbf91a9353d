#include "fusion/streetmap/local_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

namespace infuse::streetmap {
namespace {

/// Sweep built return by return, in the lidar frame; the lidar is 1.5 m above the vehicle origin.
class Scan {
 public:
  void add(const Eigen::Vector3d& vehicle, float reflectivity, uint16_t ring = 0,
           uint32_t column = UINT32_MAX) {
    const Eigen::Vector3d p = vehicle - Eigen::Vector3d(0, 0, 1.5);
    const size_t n = sweep_.size();
    sweep_.resize(n + 1);
    sweep_.rings = 4;
    sweep_.x[n] = static_cast<float>(p.x());
    sweep_.y[n] = static_cast<float>(p.y());
    sweep_.z[n] = static_cast<float>(p.z());
    sweep_.range[n] = static_cast<float>(p.norm());
    sweep_.reflectivity[n] = reflectivity;
    sweep_.ring[n] = ring;
    sweep_.column[n] = static_cast<uint16_t>(column == UINT32_MAX ? 2 * n : column);
  }
  DeskewedView view() const {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation().z() = 1.5;
    return {sweep_, sweep_.x, sweep_.y, sweep_.z, T};
  }

 private:
  Sweep sweep_;
};

LocalGridOptions small() {
  LocalGridOptions options;
  options.extent = 20;
  options.block_size = 1;
  options.cell_size = 0.5;
  return options;
}

/// Returns the sample nearest to a point, or -1.
Eigen::Index sample_at(const GridSamples& samples, double x, double y) {
  for (size_t i = 0; i < samples.size(); ++i) {
    if (std::abs(samples.x[i] - x) < 0.26 && std::abs(samples.y[i] - y) < 0.26) {
      return static_cast<Eigen::Index>(i);
    }
  }
  return -1;
}

TEST(LocalGrid, StandardisesTheFeaturesOfReturns) {
  Scan scan;
  scan.add({3.2, 1.2, 0.0}, 0.2F);
  scan.add({3.3, 1.3, 0.0}, 0.4F);  // the same cell: mean 0.3
  scan.add({5.2, -2.2, 1.0}, 0.9F);
  scan.add({-4.2, 0.2, 0.25}, 0.6F);
  scan.add({6, 6, 5.0}, 0.6F);      // too high
  scan.add({15, 0, 0.0}, 0.6F);     // too far
  scan.add({0.3, 0.1, 1.0}, 0.6F);  // the vehicle itself
  LocalGrid grid(small());
  grid.add(scan.view(), nullptr, {});
  GridSamples samples;
  grid.draw_samples({}, samples);
  ASSERT_EQ(samples.size(), 3U);
  ASSERT_EQ(samples.features.cols(), kLidarFeatureCount);
  // Heights enter as roots: 0, 1, 0.5. Reflectivities 0.3, 0.9, 0.6.
  const double z = std::sqrt(1.5);
  const auto a = sample_at(samples, 3.25, 1.25), b = sample_at(samples, 5.25, -2.25),
             c = sample_at(samples, -4.25, 0.25);
  ASSERT_TRUE(a >= 0 && b >= 0 && c >= 0);
  for (const int f : {kHeight, kReflectivity}) {
    EXPECT_NEAR(samples.features(a, f), -z, 1e-3);
    EXPECT_NEAR(samples.features(b, f), z, 1e-3);
    EXPECT_NEAR(samples.features(c, f), 0, 1e-3);
  }
  EXPECT_EQ(samples.features(a, kDiscontinuity), 0);  // all equal
}

TEST(LocalGrid, DiscontinuityIsTheRangeStepToFartherNeighbours) {
  Scan scan;
  // One ring; ranges 4, 4, 8, 8 at neighbouring columns, then a gap.
  const double ranges[] = {4, 4, 8, 8, 4};
  for (int i = 0; i < 5; ++i) {
    const double angle = 0.09 * i;
    scan.add({ranges[i] * std::cos(angle), ranges[i] * std::sin(angle), 1.5}, 0.5F, 1,
             static_cast<uint32_t>(i < 4 ? i : 10));
  }
  LocalGridOptions options = small();
  options.cell_size = 0.2;
  LocalGrid grid(options);
  grid.add(scan.view(), nullptr, {});
  GridSamples samples;
  grid.draw_samples({}, samples);
  ASSERT_EQ(samples.size(), 5U);
  // Only the second is in front of a farther neighbour: √4 = 2, the others 0.
  int raised = 0;
  for (Eigen::Index i = 0; i < 5; ++i) {
    const double value = samples.features(i, kDiscontinuity);
    const double range =
        std::hypot(samples.x[static_cast<size_t>(i)], samples.y[static_cast<size_t>(i)]);
    if (value > 0) {
      ++raised;
      EXPECT_NEAR(range, 4, 0.5);
      EXPECT_NEAR(value, 2.0, 1e-3);  // (2 − 0.4) / 0.8
    } else {
      EXPECT_NEAR(value, -0.5, 1e-3);
    }
  }
  EXPECT_EQ(raised, 1);
}

TEST(LocalGrid, StaysFixedWhileTheVehicleMoves) {
  Scan scan;
  scan.add({6.25, 2.25, 0}, 0.1F);
  scan.add({8.25, -2.25, 1}, 0.9F);
  LocalGrid grid(small());
  const PlanarPose first{100, 50, 0};
  grid.add(scan.view(), nullptr, first);
  const PlanarPose moved = first.compose({4, 1, M_PI / 2});
  GridSamples samples;
  grid.draw_samples(moved, samples);
  ASSERT_EQ(samples.size(), 2U);
  // (6.25, 2.25) seen from (4, 1) and turned left: (1.25, −2.25).
  EXPECT_GE(sample_at(samples, 1.25, -2.25), 0);
  EXPECT_GE(sample_at(samples, -3.25, -4.25), 0);
  // Far on, all cells are overwritten.
  grid.draw_samples(first.compose({200, 0, 0}), samples);
  EXPECT_EQ(samples.size(), 0U);
}

TEST(LocalGrid, MovingObjectsFade) {
  LocalGridOptions options = small();
  options.mean_window = 10;
  LocalGrid grid(options);
  Scan car, road;
  car.add({5.25, 0.25, 1.0}, 0.9F);
  car.add({-5.25, 0.25, 0.0}, 0.1F);
  road.add({5.25, 0.25, 0.0}, 0.1F);
  road.add({-5.25, 0.25, 0.0}, 0.2F);
  road.add({0.25, 5.25, 1.0}, 0.2F);
  for (int i = 0; i < 20; ++i) grid.add(car.view(), nullptr, {});
  for (int i = 0; i < 40; ++i) grid.add(road.view(), nullptr, {});
  GridSamples samples;
  grid.draw_samples({}, samples);
  ASSERT_EQ(samples.size(), 3U);
  const auto cleared = sample_at(samples, 5.25, 0.25), other = sample_at(samples, -5.25, 0.25);
  EXPECT_NEAR(samples.features(cleared, kHeight), samples.features(other, kHeight), 0.1);
}

TEST(LocalGrid, ColoursComeFromTheImageUnlessOccluded) {
  // A camera at the lidar looking forward (x); left half red, right half blue.
  CameraIntrinsics intrinsics;
  intrinsics.width = 200;
  intrinsics.height = 100;
  intrinsics.fx = intrinsics.fy = 100;
  intrinsics.cx = 99.5;
  intrinsics.cy = 49.5;
  CameraFrame frame;
  frame.width = 200;
  frame.height = 100;
  frame.format = PixelFormat::kBgr8;
  frame.pixels.resize(200 * 100 * 3, 0);
  for (size_t i = 0; i < 200 * 100; ++i) frame.pixels[3 * i + (i % 200 < 100 ? 2 : 0)] = 255;
  ImageFeatures features;
  ASSERT_TRUE(extract_features(frame, 1, features));
  const geometry::CameraModel camera(intrinsics);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  const ImageView image{features, camera, T};
  Scan scan;
  scan.add({6.25, 2.25, 1.5}, 0.5F);   // left: red
  scan.add({6.25, -2.25, 1.5}, 0.4F);  // right: blue
  scan.add({3.25, 0.75, 1.5}, 0.5F);   // a near object, red
  scan.add({9.25, 2.25, 1.55}, 0.5F);  // behind it in the image: occluded
  scan.add({-6.25, 0.25, 1.5}, 0.6F);  // behind the camera
  LocalGrid grid(small());
  grid.add(scan.view(), &image, {});
  GridSamples samples;
  grid.draw_samples({}, samples);
  ASSERT_EQ(samples.features.cols(), kFeatureCount);
  const auto red = sample_at(samples, 6.25, 2.25), blue = sample_at(samples, 6.25, -2.25);
  const auto hidden = sample_at(samples, 9.25, 2.25), behind = sample_at(samples, -6.25, 0.25);
  EXPECT_GT(samples.features(red, kRed), 0.5);
  EXPECT_LT(samples.features(red, kBlue), -0.5);
  EXPECT_LT(samples.features(blue, kRed), -0.5);
  EXPECT_GT(samples.features(blue, kBlue), 0.5);
  EXPECT_EQ(samples.features(hidden, kRed), 0);  // unknown: the mean
  EXPECT_EQ(samples.features(behind, kRed), 0);
}

TEST(LocalGrid, SamplesAreBoundedAndRepeatable) {
  Scan scan;
  for (int i = 0; i < 400; ++i) {
    scan.add({2.0 + i % 20 * 0.37, 1.0 + i / 20 * 0.37, 0.001 * i}, 0.5F);
  }
  LocalGridOptions options = small();
  options.max_samples = 60;
  LocalGrid one(options), two(options);
  one.add(scan.view(), nullptr, {});
  two.add(scan.view(), nullptr, {});
  GridSamples a, b;
  one.draw_samples({}, a);
  two.draw_samples({}, b);
  EXPECT_EQ(a.size(), 60U);
  EXPECT_EQ(a.x, b.x);
  EXPECT_TRUE(a.features == b.features);
  one.clear();
  one.draw_samples({}, a);
  EXPECT_EQ(a.size(), 0U);
}

TEST(ImageFeatures, ContainColoursAndTheSobelGradientOfAStep) {
  CameraFrame frame;
  frame.width = 8;
  frame.height = 6;
  frame.pixels.resize(48);
  for (size_t i = 0; i < 48; ++i) frame.pixels[i] = i % 8 < 4 ? 0 : 255;
  ImageFeatures features;
  ASSERT_TRUE(extract_features(frame, 1, features));
  EXPECT_FLOAT_EQ(features.at(6, 3)[0], 1);
  EXPECT_FLOAT_EQ(features.at(1, 3)[2], 0);
  // Beside the step: |g| = 4, to the right.
  EXPECT_NEAR(features.at(3, 3)[3], std::sqrt(4 / 5.66), 1e-5);
  EXPECT_NEAR(features.at(3, 3)[4], 0, 1e-6);
  EXPECT_EQ(features.at(1, 3)[3], 0);
  ASSERT_TRUE(extract_features(frame, 2, features));
  EXPECT_EQ(features.width, 4);
  EXPECT_FALSE(extract_features(frame, 4, features));
  frame.format = PixelFormat::kBayerBggr8;
  EXPECT_FALSE(extract_features(frame, 1, features));
}

}  // namespace
}  // namespace infuse::streetmap
