#include "fusion/calibration/image_features.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace infuse::calibration {
namespace {

Plane noise(int width, int height, int levels, uint64_t seed) {
  std::mt19937_64 random(seed);
  Plane plane{.width = width, .height = height, .values = {}};
  for (int i = 0; i < width * height; ++i) {
    plane.values.push_back(static_cast<float>(random() % static_cast<uint64_t>(levels)));
  }
  return plane;
}

float at(const Plane& plane, int u, int v) {
  const int uu = std::clamp(u, 0, plane.width - 1);
  const int vv = std::clamp(v, 0, plane.height - 1);
  return plane.values[static_cast<size_t>(vv * plane.width + uu)];
}

TEST(GreyPlane, WeighsTheColours) {
  CameraFrame frame;
  frame.width = 4;
  frame.height = 1;
  frame.format = PixelFormat::kBgr8;
  frame.pixels = {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255};
  // BT.601: 0.114 blue, 0.587 green, 0.299 red, rounded.
  EXPECT_THAT(grey_plane(frame).values, testing::ElementsAre(29, 150, 76, 255));
  frame.format = PixelFormat::kGrey8;
  frame.pixels = {0, 7, 200, 255};
  EXPECT_THAT(grey_plane(frame).values, testing::ElementsAre(0, 7, 200, 255));
}

TEST(EdgeStrength, IsTheLargestStepToANeighbour) {
  const Plane grey = noise(17, 11, 256, 1);
  const Plane edge = edge_strength(grey);
  ASSERT_EQ(edge.values.size(), grey.values.size());
  for (int v = 0; v < grey.height; ++v) {
    for (int u = 0; u < grey.width; ++u) {
      float largest = 0;
      for (int dv = -1; dv <= 1; ++dv) {
        for (int du = -1; du <= 1; ++du) {
          largest = std::max(largest, std::abs(at(grey, u + du, v + dv) - at(grey, u, v)));
        }
      }
      EXPECT_EQ(at(edge, u, v), largest) << u << ", " << v;
    }
  }
}

TEST(Equalized, RanksBesideABruteForceCount) {
  const Plane plane = noise(19, 13, 40, 2);
  const Plane ranks = equalized(plane);
  const auto n = static_cast<double>(plane.values.size());
  for (size_t i = 0; i < plane.values.size(); ++i) {
    const float value = plane.values[i];
    const auto below =
        std::count_if(plane.values.begin(), plane.values.end(), [&](float w) { return w < value; });
    const auto equal = std::count(plane.values.begin(), plane.values.end(), value);
    EXPECT_NEAR(ranks.values[i],
                (static_cast<double>(below) + 0.5 * static_cast<double>(equal - 1)) / n, 1e-6);
  }
}

/// The definition: a sum over the whole plane's neighbourhood, borders replicated.
double gaussian_at(const Plane& plane, int u, int v, double sigma) {
  const int reach = static_cast<int>(std::ceil(3 * sigma));
  double sum = 0;
  double weights = 0;
  for (int dv = -reach; dv <= reach; ++dv) {
    for (int du = -reach; du <= reach; ++du) {
      const double weight = std::exp(-0.5 * (du * du + dv * dv) / (sigma * sigma));
      sum += weight * at(plane, u + du, v + dv);
      weights += weight;
    }
  }
  return sum / weights;
}

TEST(Blurred, IsAGaussianMean) {
  const Plane plane = noise(23, 14, 256, 3);
  const Plane smooth = blurred(plane, 1.7);
  for (const auto& [u, v] : {std::pair{0, 0}, {22, 13}, {11, 7}, {3, 12}}) {
    EXPECT_NEAR(at(smooth, u, v), gaussian_at(plane, u, v, 1.7), 1e-3) << u << ", " << v;
  }
}

TEST(Blurred, ThinsToEveryStepthPixel) {
  const Plane plane = noise(23, 14, 256, 4);
  const Plane full = blurred(plane, 3);
  const Plane thin = blurred(plane, 3, 4);
  EXPECT_EQ(thin.step, 4);
  ASSERT_EQ(thin.width, 6);
  ASSERT_EQ(thin.height, 4);
  for (int v = 0; v < thin.height; ++v) {
    for (int u = 0; u < thin.width; ++u) EXPECT_FLOAT_EQ(at(thin, u, v), at(full, 4 * u, 4 * v));
  }
}

TEST(Blurred, AThinPlaneIsBlurredInPixels) {
  Plane ramp{.width = 64, .height = 8, .values = {}};
  for (int v = 0; v < 8; ++v) {
    for (int u = 0; u < 64; ++u) ramp.values.push_back(static_cast<float>(std::sin(0.1 * u)));
  }
  // Of a sine of 0.1 rad a pixel, a Gaussian of 6 pixels leaves exp(−½ 0.6²), in one go or in two.
  const Plane once = blurred(ramp, 6, 2);
  const Plane twice = blurred(blurred(ramp, 4, 2), std::sqrt(20.0), 2);
  const double left = std::exp(-0.5 * 0.36);
  for (const int u : {13, 16, 18}) {
    EXPECT_NEAR(at(once, u, 2), left * std::sin(0.2 * u), 0.01);
    EXPECT_NEAR(at(twice, u, 2), at(once, u, 2), 0.01);
  }
}

TEST(Blurred, NoBlurChangesNothing) {
  const Plane plane = noise(9, 5, 256, 5);
  EXPECT_EQ(blurred(plane, 0).values, plane.values);
}

}  // namespace
}  // namespace infuse::calibration
