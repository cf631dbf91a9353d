#include "fusion/features/neighbour_search.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "fusion/registration/prepared_cloud.hpp"
#include "tests/fusion/registration/random_room.hpp"

namespace infuse::registration {
namespace {

using features::Floats;
using features::kLanes;
using features::Nearest;
using features::NearestOfEach;
using features::NearestQueries;
using features::Neighbourhoods;

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

TEST(NeighbourSearch, FindsTheNearestPointsInOrder) {
  const PointCloud cloud = random_room(1, 1500, 0.02, Eigen::Isometry3d::Identity());
  NeighbourSearch search;
  search.build(cloud.points());
  const PointCloud queries = random_room(2, 100, 1.0, Eigen::Isometry3d::Identity());
  for (const size_t wanted : {1U, 7U, 40U}) {
    std::vector<int32_t> indices(wanted);
    std::vector<float> squares(wanted);
    for (size_t i = 0; i < queries.size(); ++i) {
      const float p[3] = {queries.x[i], queries.y[i], queries.z[i]};
      const auto all = brute_force(cloud, p);
      const size_t count = search.nearest_points(p, 1.0F, indices, squares);
      const auto near = static_cast<size_t>(
          std::ranges::count_if(all, [](const auto& point) { return point.first < 1.0F; }));
      ASSERT_EQ(count, std::min(near, wanted));
      for (size_t k = 0; k < count; ++k) {
        EXPECT_EQ(squares[k], all[k].first);
        EXPECT_EQ(indices[k], all[k].second);
      }
    }
  }
}

TEST(NeighbourSearch, FindsTheNearestOfEachOfSixteen) {
  const PointCloud cloud = random_room(1, 1500, 0.02, Eigen::Isometry3d::Identity());
  NeighbourSearch search;
  search.build(cloud.points());
  PointCloud all = random_room(2, 1600, 1.0, Eigen::Isometry3d::Identity());
  NeighbourSearch of_all;
  build_and_sort(all, of_all);
  int far = 0;
  for (size_t begin = 0; begin < all.size(); begin += kLanes) {
    NearestQueries queries{{}, Floats{} - 1};
    for (int i = 0; i < kLanes; ++i) {
      if (i % 5 == 4) continue;  // not sought
      const size_t k = begin + static_cast<size_t>(i);
      queries.at[0][i] = all.x[k], queries.at[1][i] = all.y[k], queries.at[2][i] = all.z[k];
      queries.max_distance[i] = 0.2F * static_cast<float>(1 + i % 4);
    }
    const NearestOfEach found = search.nearest_of_each(queries, 0.3F);
    for (int i = 0; i < kLanes; ++i) {
      const float max_distance = queries.max_distance[i];
      if (max_distance < 0) continue;
      const float p[3] = {queries.at[0][i], queries.at[1][i], queries.at[2][i]};
      const auto truth = brute_force(cloud, p);
      const float best = std::sqrt(truth[0].first), second = std::sqrt(truth[1].first);
      if (best > max_distance) {
        ++far;
        EXPECT_EQ(found.index[i], -1);
        EXPECT_LE(found.others[i], best * 1.00001F);
      } else {
        EXPECT_EQ(found.index[i], truth[0].second);
        EXPECT_FLOAT_EQ(found.square_distance[i], truth[0].first);
        EXPECT_LE(found.others[i], second * 1.00001F);
        EXPECT_GE(found.others[i] * 1.00001F, std::min(second, best + 0.3F));
      }
    }
  }
  EXPECT_GT(far, 100);
}

TEST(NeighbourSearch, SumsOverTheNeighboursOfEachPoint) {
  std::vector<NeighbourSearch::Point> memory;
  for (const size_t size : {1U, 7U, 16U, 17U, 100U, 1500U}) {
    const PointCloud cloud = random_room(1, size, 0.02, Eigen::Isometry3d::Identity());
    NeighbourSearch search;
    search.build(cloud.points());
    size_t seen = 0;
    for (const NeighbourSearch::Leaf& leaf : search.leaves()) {
      const Neighbourhoods sums = search.neighbourhoods(leaf, 10, memory);
      for (int lane = 0; lane < kLanes; ++lane) {
        if (leaf.index[lane] < 0) {
          EXPECT_EQ(sums.count[lane], 0);
          continue;
        }
        ++seen;
        const auto i = static_cast<size_t>(leaf.index[lane]);
        const float p[3] = {cloud.x[i], cloud.y[i], cloud.z[i]};
        const auto all = brute_force(cloud, p);
        const size_t count = std::min<size_t>(size, 10);
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();
        for (size_t k = 0; k < count; ++k) {
          const auto j = static_cast<size_t>(all[k].second);
          const Eigen::Vector3d d(cloud.x[j] - p[0], cloud.y[j] - p[1], cloud.z[j] - p[2]);
          sum += d;
          cross += d * d.transpose();
        }
        EXPECT_EQ(sums.count[lane], static_cast<float>(count));
        const double tolerance = 1e-6 * (1 + cross.trace());
        for (int axis = 0; axis < 3; ++axis)
          EXPECT_NEAR(sums.sum[axis][lane], sum[axis], tolerance);
        constexpr int kRow[6] = {0, 0, 0, 1, 1, 2}, kColumn[6] = {0, 1, 2, 1, 2, 2};
        for (int e = 0; e < 6; ++e) {
          EXPECT_NEAR(sums.cross[e][lane], cross(kRow[e], kColumn[e]), tolerance);
        }
      }
    }
    EXPECT_EQ(seen, size);
  }
}

TEST(NeighbourSearch, SortsACloudByItsLeaves) {
  PointCloud cloud = random_room(1, 1000, 0.02, Eigen::Isometry3d::Identity());
  const PointCloud before = cloud;
  NeighbourSearch search;
  build_and_sort(cloud, search);
  ASSERT_EQ(cloud.size(), before.size());
  const auto sorted = [](FieldVector<float> values) {
    std::sort(values.begin(), values.end());
    return values;
  };
  EXPECT_EQ(sorted(cloud.x), sorted(before.x));
  for (size_t i = 0; i < cloud.size(); ++i) {
    const float p[3] = {cloud.x[i], cloud.y[i], cloud.z[i]};
    EXPECT_EQ(search.nearest(p, 1, 0).index, static_cast<int32_t>(i));
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
