#include "fusion/registration/neighbour_search.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "fusion/registration/voxel_downsample.hpp"
#include "tests/fusion/registration/random_room.hpp"

namespace infuse::registration {
namespace {

std::vector<std::pair<float, int32_t>> brute_force(const PointCloud& cloud, const float* p) {
  std::vector<std::pair<float, int32_t>> all;
  for (size_t i = 0; i < cloud.size(); ++i) {
    const float dx = cloud.x[i] - p[0], dy = cloud.y[i] - p[1], dz = cloud.z[i] - p[2];
    all.emplace_back(dx * dx + dy * dy + dz * dz, static_cast<int32_t>(i));
  }
  std::sort(all.begin(), all.end());
  return all;
}

TEST(NeighbourSearch, FindsWhatBruteForceFinds) {
  for (const size_t size : {1U, 2U, 15U, 16U, 17U, 100U, 1500U}) {
    const PointCloud cloud = random_room(1, size, 0.02, Eigen::Isometry3d::Identity());
    NeighbourSearch search;
    search.build(cloud.points());
    ASSERT_EQ(search.size(), size);
    const PointCloud queries = random_room(2, 200, 1.0, Eigen::Isometry3d::Identity());
    for (size_t i = 0; i < queries.size(); ++i) {
      const float p[3] = {queries.x[i], queries.y[i], queries.z[i]};
      const auto all = brute_force(cloud, p);
      int32_t indices[NeighbourSearch::kMaxNeighbours];
      float squares[NeighbourSearch::kMaxNeighbours];
      const int found = search.nearest_neighbours(p, 10, indices, squares);
      ASSERT_EQ(found, static_cast<int>(std::min<size_t>(size, 10)));
      for (int k = 0; k < found; ++k) {
        EXPECT_FLOAT_EQ(squares[k], all[static_cast<size_t>(k)].first);
      }
      const Nearest nearest = search.nearest(p, 2.0F, 0.3F);
      const float best = std::sqrt(all[0].first);
      if (best > 2.0F) {
        EXPECT_EQ(nearest.index, -1);
        EXPECT_LE(nearest.others, best * 1.00001F);
      } else {
        EXPECT_EQ(nearest.index, all[0].second);
        const float second = size > 1 ? std::sqrt(all[1].first) : 1e9F;
        EXPECT_LE(nearest.others, second * 1.00001F);
        EXPECT_GE(nearest.others * 1.00001F, std::min(second, best + 0.3F));
      }
    }
  }
}

TEST(NeighbourSearch, LeavesOutWhatIsNotFinite) {
  PointCloud cloud = random_room(1, 100, 0.02, Eigen::Isometry3d::Identity());
  for (size_t i = 0; i < 100; i += 2) cloud.y[i] = std::numeric_limits<float>::quiet_NaN();
  cloud.x[1] = std::numeric_limits<float>::infinity();
  NeighbourSearch search;
  search.build(cloud.points());
  EXPECT_EQ(search.size(), 49U);
  const float nan[3] = {0, 0, std::numeric_limits<float>::quiet_NaN()};
  EXPECT_EQ(search.nearest(nan, 1, 0.1F).index, -1);
  search.build(PointCloud().points());
  EXPECT_EQ(search.nearest(nan, 1, 0.1F).index, -1);
}

TEST(VoxelDownsample, GivesTheMeanOfEveryVoxel) {
  PointCloud cloud;
  cloud.resize(6);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float x[6] = {-0.9F, -0.1F, 0.1F, nan, 1e9F, -0.5F};
  for (size_t i = 0; i < 6; ++i) cloud.x[i] = x[i], cloud.y[i] = 0.25F, cloud.z[i] = -7.5F;
  const PointCloud out = voxel_downsample(cloud.points(), 1.0);
  ASSERT_EQ(out.size(), 2U);
  EXPECT_FLOAT_EQ(out.x[0], -0.5F);
  EXPECT_FLOAT_EQ(out.x[1], 0.1F);
  EXPECT_FLOAT_EQ(out.y[0], 0.25F);
  EXPECT_FLOAT_EQ(out.z[0], -7.5F);
  EXPECT_EQ(out.nx[0], 0.0F);
}

}  // namespace
}  // namespace infuse::registration
