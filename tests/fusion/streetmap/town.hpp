#pragma once

#include <gtest/gtest.h>

#include <random>

#include "fusion/streetmap/label_window.hpp"
#include "fusion/streetmap/local_grid.hpp"
#include "fusion/streetmap/rasterise.hpp"

/// A small town on a map, and views of it: features drawn by the kind of ground.
namespace infuse::streetmap::town {

/// A map and its bytes.
struct Town {
  std::vector<std::byte> bytes;
  SegmentMap map;
};

/// Two streets that cross at the origin, houses on both sides at irregular distances, a park.
inline StreetPlan plan() {
  StreetPlan plan;
  plan.strips.push_back({{SegmentKind::kCarriageway, 1}, {{-150, 0}, {150, 0}}, 3, 0.4, 2.4});
  plan.strips.push_back({{SegmentKind::kCarriageway, 2}, {{0, -90}, {0, 90}}, 2.5, 0.4, 2.4});
  std::mt19937 random(5);
  std::uniform_real_distribution<double> share(0, 1);
  int64_t id = 100;
  for (const double side : {-1.0, 1.0}) {
    for (double x = -140; x < 140;) {
      const double width = 8 + 8 * share(random), gap = 2 + 6 * share(random);
      const double front = side * (8 + 2 * share(random)), back = front + side * 10;
      if (std::abs(x + width / 2) > 10 + width / 2) {
        Polyline ring{{x, front}, {x + width, front}, {x + width, back}, {x, back}};
        plan.areas.push_back({{SegmentKind::kBuilding, id++}, {ring}, 0.8});
      }
      x += width + gap;
    }
  }
  plan.areas.push_back({{SegmentKind::kGreen, 50}, {{{-60, 25}, {-10, 25}, {-10, 80}, {-60, 80}}}});
  return plan;
}

/// Streets of 6 m width at the given places, which all cross.
inline StreetPlan lattice(const std::vector<double>& at_x, const std::vector<double>& at_y) {
  StreetPlan plan;
  const auto add = [&](const Polyline& points) {
    plan.strips.push_back({{SegmentKind::kCarriageway, 1}, points, 3, 0.4, 2, 2});
  };
  for (const double x : at_x) add({{x, at_y.front()}, {x, at_y.back()}});
  for (const double y : at_y) add({{at_x.front(), y}, {at_x.back(), y}});
  return plan;
}

/// Streets at distances that do not repeat.
inline StreetPlan irregular_streets() {
  return lattice({0, 70, 160, 300, 385, 510, 565, 700}, {0, 95, 150, 270, 430, 500});
}

/// Blocks of 100 m that are alike for odometry, with parks beside the streets that are not.
inline StreetPlan alike_blocks() {
  const std::vector<double> every{0, 100, 200, 300};
  StreetPlan plan = lattice(every, every);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> share(0, 1);
  int64_t id = 1000;
  for (const double x : {50.0, 150.0, 250.0}) {
    for (const double y : {50.0, 150.0, 250.0}) {
      for (int i = 0; i < 8; ++i) {
        const bool upright = share(random) < 0.5, far = share(random) < 0.5;
        const double along = 70 * share(random) - 40, across = far ? 30 : -45;
        const double left = x + (upright ? across : along), low = y + (upright ? along : across);
        const double width = upright ? 15 : 10 + 10 * share(random);
        const double height = upright ? 10 + 10 * share(random) : 15;
        plan.areas.push_back({{SegmentKind::kGreen, id++},
                              {{{left, low},
                                {left + width, low},
                                {left + width, low + height},
                                {left, low + height}}}});
      }
    }
  }
  return plan;
}

/// Part of a drive: straight on, and then a turn of 6 m radius.
struct Leg {
  double length = 0;  ///< m
  double turn = 0;    ///< rad
};

/// From (20, -1) east, left at x = 160, right at y = 150, left at x = 385, left at y = 430.
inline std::vector<Leg> irregular_drive() {
  constexpr double kLeft = 1.5707963;
  return {{134, kLeft}, {138, -kLeft}, {213, kLeft}, {268, kLeft}, {150}};
}

/// From (20, -1) east through alike blocks: eight places fit.
inline std::vector<Leg> alike_drive() {
  constexpr double kLeft = 1.5707963;
  return {{74, kLeft}, {88, -kLeft}, {88, kLeft}, {88, kLeft}, {88, -kLeft}, {80}};
}

inline Town build(const StreetPlan& plan) {
  Town town;
  auto bytes = rasterise(plan, {.margin = 60}, "town");
  EXPECT_TRUE(bytes);
  town.bytes = std::move(*bytes);
  const auto map = SegmentMap::open(town.bytes, "town");
  EXPECT_TRUE(map);
  town.map = *map;
  return town;
}

/// Samples a view at `pose`: points within 18 m outside houses, each with features of its kind of
/// ground and noise. `blind`: features independent of the ground.
inline GridSamples sample_view(const SegmentMap& map, const PlanarPose& pose, uint64_t seed,
                               bool unrelated = false) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> place(-18, 18);
  std::normal_distribution<double> noise;
  GridSamples samples;
  std::vector<std::array<double, 3>> rows;
  while (rows.size() < 700) {
    const Eigen::Vector2d p(place(random), place(random)), q = pose.transform(p);
    const auto kind = static_cast<int>(map.segment(map.id_at(q.x(), q.y())).kind);
    if (kind == static_cast<int>(SegmentKind::kBuilding)) continue;
    const int visible_kind = unrelated ? 0 : kind;
    rows.push_back({1.4 * (visible_kind % 3) + noise(random),
                    1.3 * (visible_kind % 2) + noise(random),
                    1.1 * (visible_kind / 3) + noise(random)});
    samples.x.push_back(static_cast<float>(p.x()));
    samples.y.push_back(static_cast<float>(p.y()));
  }
  samples.features.resize(static_cast<Eigen::Index>(rows.size()), 3);
  for (size_t i = 0; i < rows.size(); ++i) {
    for (size_t k = 0; k < 3; ++k) {
      samples.features(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = rows[i][k];
    }
  }
  return samples;
}

}  // namespace infuse::streetmap::town
