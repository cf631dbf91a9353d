#include "fusion/mapping/moving_points.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>

namespace infuse::mapping {
namespace {

/// A world seen by a lidar at (x, 0, 0), 1.7 m above flat ground: walls at y = ±12 m and a box of
/// 4 × 2 × 1.5 m at (box_x, 4), by casting rays in closed form. The submap's frame is the lidar's.
struct World {
  static constexpr double kHeight = 1.7, kWall = 12;

  static double range_of(const Eigen::Vector3d& d, double box_x) {
    double range = 1e9;
    if (d.z() < 0) range = std::min(range, -kHeight / d.z());
    if (d.y() != 0) range = std::min(range, kWall / std::abs(d.y()));
    // Slabs of the box.
    const Eigen::Vector3d low(box_x - 2, 3, -kHeight), high(box_x + 2, 5, -kHeight + 1.5);
    double enter = 0, leave = 1e9;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = low[axis] / d[axis], b = high[axis] / d[axis];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    if (enter > 0 && enter < leave) range = std::min(range, enter);
    return range;
  }

  /// `box_x`: of the box, relative to the lidar.
  static Submap scan(double box_x) {
    Submap out;
    for (int ring = 0; ring < 32; ++ring) {
      const double elevation = -0.4 + 0.02 * ring + 1e-4;
      for (int step = 0; step < 900; ++step) {
        const double azimuth = 2 * M_PI * (step + 0.5) / 900;
        const Eigen::Vector3d d(std::cos(elevation) * std::cos(azimuth),
                                std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
        const double range = range_of(d, box_x);
        if (range > 80) continue;
        const Eigen::Vector3f p = (range * d).cast<float>();
        out.x.push_back(p.x());
        out.y.push_back(p.y());
        out.z.push_back(p.z());
        out.reflectivity.push_back(0.5F);
      }
    }
    return out;
  }

  static bool on_box(const Submap& scan, size_t i, double box_x) {
    return std::abs(scan.x[i] - box_x) < 2.01 && scan.y[i] > 2.99 && scan.y[i] < 5.01 &&
           scan.z[i] > -kHeight + 0.01;
  }
};

/// Shares of the points on the box and of all others that are found to move, where the lidar
/// moves by 3 m a view and the box stands at `box_x` + `box_step` · view along the road.
struct Shares {
  double box = 0, rest = 0;
};

Shares shares_of(double box_x, double box_step) {
  constexpr int kViews = 9, kMiddle = 4;
  const auto box_of = [&](int view) { return box_x + box_step * view - 3.0 * view; };
  std::deque<SubmapView> views;
  for (int v = 0; v < kViews; ++v) views.emplace_back(World::scan(box_of(v)));
  std::vector<PlacedView> others;
  for (int v = 0; v < kViews; ++v) {
    if (v == kMiddle) continue;
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation().x() = 3.0 * (kMiddle - v);
    others.push_back({&views[static_cast<size_t>(v)], T});
  }
  const Submap& middle = views[kMiddle].submap;
  const std::vector<bool> moving = find_moving_points(middle, others);
  double box = 0, box_moving = 0, rest = 0, rest_moving = 0;
  for (size_t i = 0; i < middle.size(); ++i) {
    const bool on_box = World::on_box(middle, i, box_of(kMiddle));
    ++(on_box ? box : rest);
    if (moving[i]) ++(on_box ? box_moving : rest_moving);
  }
  EXPECT_GT(box, 100);
  EXPECT_EQ(without_moving_points(middle, moving).size(),
            static_cast<size_t>(box + rest - box_moving - rest_moving));
  return {box_moving / box, rest_moving / rest};
}

TEST(MovingPoints, WhatStandsStays) {
  const Shares shares = shares_of(12, 0);
  EXPECT_EQ(shares.box, 0);
  EXPECT_LT(shares.rest, 1e-3);
}

TEST(MovingPoints, AVehicleThatComesTowardsIsFound) {
  const Shares shares = shares_of(24, -3);
  EXPECT_GT(shares.box, 0.9);
  EXPECT_LT(shares.rest, 2e-3);
}

// Always at the same place as seen from the lidar: each view has a point there, of its own frame.
TEST(MovingPoints, AVehicleAheadAtTheSameSpeedIsFound) {
  const Shares shares = shares_of(-6, 3);
  EXPECT_GT(shares.box, 0.7);
  EXPECT_LT(shares.rest, 2e-3);
}

}  // namespace
}  // namespace infuse::mapping
