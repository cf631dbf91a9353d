#include "fusion/features/image_edges.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "fusion/features/local_contrast.hpp"

namespace infuse::features {
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

TEST(ReduceByMeans, DropsWhatIsLeftOver) {
  CameraFrame frame;
  frame.width = 5;
  frame.height = 3;
  frame.format = PixelFormat::kGrey8;
  frame.pixels = {1, 2, 3, 4, 99, 5, 6, 7, 12, 99, 99, 99, 99, 99, 99};
  Plane plane;
  reduce_by_means(frame, 2, plane);
  EXPECT_EQ(plane.width, 2);
  EXPECT_EQ(plane.height, 1);
  EXPECT_THAT(plane.values, testing::ElementsAre(3.5F, 6.5F));
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

/// |n · ∇I| by Sobel's masks.
float expected_ring_edge(const Plane& grey, int u, int v, float right, float down) {
  float across = 0, downwards = 0;
  for (int k = -1; k <= 1; ++k) {
    const float weight = k == 0 ? 2 : 1;
    across += weight * (at(grey, u + 1, v + k) - at(grey, u - 1, v + k));
    downwards += weight * (at(grey, u + k, v + 1) - at(grey, u + k, v - 1));
  }
  return std::abs(right * across + down * downwards) / 4;
}

TEST(RingEdge, IsTheChangeAlongTheRing) {
  const Plane grey = noise(37, 21, 256, 5);  // 3 × 2 cells
  const RingDirections rings{.columns = 3,
                             .rows = 2,
                             .right = {1, 0.6F, 0, 0.8F, 0, -0.6F},
                             .down = {0, 0.8F, 1, -0.6F, 0, 0.8F}};
  const Plane edge = ring_edge(grey, rings);
  const Plane along_rows = ring_edge(grey, {});
  for (int v = 0; v < grey.height; ++v) {
    for (int u = 0; u < grey.width; ++u) {
      const auto cell = static_cast<size_t>(v / 16 * 3 + u / 16);
      const float by_hand = expected_ring_edge(grey, u, v, rings.right[cell], rings.down[cell]);
      EXPECT_NEAR(at(edge, u, v), by_hand, 1e-3) << u << ", " << v;
      EXPECT_NEAR(at(along_rows, u, v), expected_ring_edge(grey, u, v, 1, 0), 1e-3);
    }
  }
}

TEST(RingEdge, DoesNotSeeEdgesThatRingsRunAlong) {
  Plane kerb{.width = 32, .height = 32, .values = std::vector<float>(1024, 40)};
  std::fill(kerb.values.begin() + 512, kerb.values.end(), 200.0F);
  for (const float strength : ring_edge(kerb, {}).values) EXPECT_EQ(strength, 0);
  Plane post = kerb;
  for (int v = 0; v < 32; ++v) {
    for (int u = 0; u < 32; ++u) post.values[static_cast<size_t>(32 * v + u)] = u < 16 ? 40 : 200;
  }
  EXPECT_EQ(at(ring_edge(post, {}), 15, 20), 160);
  EXPECT_EQ(at(ring_edge(post, {}), 10, 20), 0);
}

TEST(RingEdge, AcceptsAnImageLargerThanTheIntrinsics) {
  const Plane grey = noise(40, 40, 256, 6);
  const RingDirections rings{.columns = 1, .rows = 1, .right = {0}, .down = {1}};
  const Plane edge = ring_edge(grey, rings);
  EXPECT_NEAR(at(edge, 35, 38), expected_ring_edge(grey, 35, 38, 0, 1), 1e-3);
}

/// From the definition: mean and standard deviation under the Gaussian, borders replicated.
float expected_local_contrast(const Plane& plane, int u, int v, double width, double floor) {
  const int reach = static_cast<int>(std::ceil(3 * width));
  double weights = 0, sum = 0, cells = 0;
  for (int dv = -reach; dv <= reach; ++dv) {
    for (int du = -reach; du <= reach; ++du) {
      const double w = std::exp(-0.5 * (du * du + dv * dv) / (width * width));
      const double g = at(plane, u + du, v + dv);
      weights += w;
      sum += w * g;
      cells += w * g * g;
    }
  }
  const double mean = sum / weights;
  const double variance = cells / weights - mean * mean;
  const double z = (at(plane, u, v) - mean) / std::sqrt(variance + floor * floor);
  return static_cast<float>(0.5 + 0.5 * z / std::sqrt(1 + z * z));
}

TEST(NormalizeLocalContrast, MatchesItsDefinition) {
  // Up to seven pixels the means are not thinned, and both agree but for rounding.
  const Plane plane = noise(40, 31, 200, 4);
  const Plane local = normalize_local_contrast(plane, 5, 3);
  ASSERT_EQ(local.values.size(), plane.values.size());
  for (int v = 0; v < plane.height; v += 5) {
    for (int u = 0; u < plane.width; u += 3) {
      EXPECT_NEAR(at(local, u, v), expected_local_contrast(plane, u, v, 5, 3), 1e-4F)
          << u << ", " << v;
    }
  }
}

TEST(NormalizeLocalContrast, IsNearItsDefinitionForLargeWidths) {
  // For larger widths means are interpolated between samples a quarter of a width apart. Near the
  // border both replicate different values.
  const Plane plane = noise(130, 110, 200, 4);
  const Plane local = normalize_local_contrast(plane, 12, 3);
  for (int v = 36; v < plane.height - 36; v += 5) {
    for (int u = 36; u < plane.width - 36; u += 7) {
      EXPECT_NEAR(at(local, u, v), expected_local_contrast(plane, u, v, 12, 3), 0.01F)
          << u << ", " << v;
    }
  }
}

TEST(NormalizeLocalContrast, SlowlyChangingLightHasNoEffect) {
  Plane plane = noise(200, 150, 50, 5);
  const Plane even = normalize_local_contrast(plane, 6, 1);
  for (int v = 0; v < plane.height; ++v) {
    for (int u = 0; u < plane.width; ++u) {
      float& value = plane.values[static_cast<size_t>(v * plane.width + u)];
      value = (0.5F + 0.004F * static_cast<float>(u)) * value + 0.2F * static_cast<float>(v);
    }
  }
  const Plane uneven = normalize_local_contrast(plane, 6, 1);
  double sum = 0;
  for (size_t i = 0; i < even.values.size(); ++i) {
    sum += std::abs(static_cast<double>(even.values[i]) - uneven.values[i]);
  }
  EXPECT_LT(sum / static_cast<double>(even.values.size()), 0.02);
}

TEST(NormalizeLocalContrast, ASmoothSurfaceIsInTheMiddle) {
  Plane plane{.width = 3, .height = 90, .values = std::vector<float>(270, 0.7F)};
  for (const float value : normalize_local_contrast(plane, 15, 0.01).values) {
    EXPECT_NEAR(value, 0.5F, 0.05F);
  }
}

/// From the definition: a sum over the whole plane's neighbourhood, borders replicated.
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
}  // namespace infuse::features
