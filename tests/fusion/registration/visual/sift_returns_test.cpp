#include "fusion/registration/visual/sift_returns.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "fusion/registration/visual/scan_features.hpp"
#include "fusion/registration/visual/visible_returns.hpp"
#include "tests/fusion/registration/visual/small_camera.hpp"

namespace infuse::registration {
namespace {

/// A camera that looks along x at a wall 10 m away with dots on it; the wall's returns lie one
/// pixel apart, and a return behind the wall in the middle.
struct Wall {
  CameraMount camera = small_camera();
  CameraFrame frame;
  Sweep sweep;
  std::vector<Eigen::Vector2d> dots{{60, 40}, {100, 50}, {50, 90}, {120, 95}, {85, 70}};

  Wall() {
    const CameraIntrinsics& k = camera.intrinsics;
    frame.width = k.width;
    frame.height = k.height;
    for (int v = 0; v < k.height; ++v) {
      for (int u = 0; u < k.width; ++u) {
        double level = 60;
        for (const Eigen::Vector2d& dot : dots) {
          level += 150 * std::exp(-(Eigen::Vector2d(u, v) - dot).squaredNorm() / 18);
        }
        frame.pixels.push_back(static_cast<uint8_t>(std::min(level, 255.0)));
        add(10, (k.cx - u) / 10, (k.cy - v) / 10);
      }
    }
    add(20, 0.1, 0.1);
  }
  void add(double x, double y, double z) {
    sweep.x.push_back(static_cast<float>(x));
    sweep.y.push_back(static_cast<float>(y));
    sweep.z.push_back(static_cast<float>(z));
    sweep.range.push_back(static_cast<float>(std::hypot(x, y, z)));
    sweep.reflectivity.push_back(0.5F);
    sweep.ring.push_back(0);
    sweep.column.push_back(0);
  }
};

TEST(SiftReturns, LieWhereTheDotsAre) {
  const Wall wall;
  const std::vector<ScanImage> images{{wall.frame, wall.camera}};
  const auto found = find_sift_returns({features::make_sweep_view(wall.sweep), images});
  ASSERT_TRUE(found) << found.error().message();
  for (const Eigen::Vector2d& dot : wall.dots) {
    double nearest = 1e9;
    for (const uint32_t i : found->returns) {
      const Eigen::Vector2d at(79.5 - 10 * wall.sweep.y[i], 59.5 - 10 * wall.sweep.z[i]);
      nearest = std::min(nearest, (at - dot).norm());
    }
    EXPECT_LT(nearest, 1.5);
  }
  EXPECT_EQ(found->descriptors.rows(), 128);
  ASSERT_EQ(found->descriptors.cols(), static_cast<Eigen::Index>(found->size()));
  for (size_t i = 0; i < found->size(); ++i) {
    EXPECT_NEAR(found->descriptors.col(static_cast<Eigen::Index>(i)).norm(), 1, 1e-5);
  }
}

TEST(VisibleReturns, AreNotHiddenAndNearest) {
  const Wall wall;
  const VisibleReturns visible({wall.sweep.x, wall.sweep.y, wall.sweep.z}, wall.camera);
  const auto hidden = static_cast<int32_t>(wall.sweep.size() - 1);
  for (int row = 0; row < 120; ++row) {
    for (int column = 0; column < 160; ++column) {
      EXPECT_EQ(visible.at(column, row), row * 160 + column);
      EXPECT_NE(visible.at(column, row), hidden);
    }
  }
  EXPECT_EQ(visible.nearest(30.4, 20.3, 1), 20 * 160 + 30);
  EXPECT_EQ(visible.nearest(-5, 20, 1), -1);
  EXPECT_EQ(visible.nearest(NAN, 20, 1), -1);
}

TEST(SiftReturns, RefusesImagesThatDoNotFit) {
  Wall wall;
  const std::vector<ScanImage> images{{wall.frame, wall.camera}};
  const CameraLidarScan scan{features::make_sweep_view(wall.sweep), images};
  wall.frame.format = PixelFormat::kBayerRggb8;
  EXPECT_THAT(find_sift_returns(scan).error().what, testing::HasSubstr("Bayer"));
  wall.frame.format = PixelFormat::kGrey8;
  wall.camera.intrinsics.width = 100;
  EXPECT_THAT(find_sift_returns(scan).error().what, testing::HasSubstr("size"));
}

TEST(ScanFeatures, HaveNamesAndOneColumnPerPoint) {
  const Wall wall;
  const std::vector<ScanImage> images{{wall.frame, wall.camera}};
  const CameraLidarScan scan{features::make_sweep_view(wall.sweep), images};
  const std::vector<Eigen::Index> rows{2, 33, 128, 161};
  for (size_t k = 0; k < rows.size(); ++k) {
    const auto kind = static_cast<ScanFeature>(k);
    EXPECT_EQ(find_scan_feature(name(kind)), kind);
    const auto features = compute_scan_features(scan, kind);
    ASSERT_TRUE(features);
    EXPECT_GT(features->size(), 0U) << name(kind);
    EXPECT_EQ(features->vectors.rows(), rows[k]);
    EXPECT_EQ(features->vectors.cols(), features->points.cols());
    EXPECT_TRUE(features->vectors.allFinite());
  }
  EXPECT_FALSE(find_scan_feature("surf"));
}

}  // namespace
}  // namespace infuse::registration
