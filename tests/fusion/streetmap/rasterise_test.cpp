#include "fusion/streetmap/rasterise.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fusion/streetmap/draw_map.hpp"
#include "fusion/streetmap/segment_map.hpp"

namespace infuse::streetmap {
namespace {

/// A map and its bytes.
struct Drawn {
  std::vector<std::byte> bytes;
  SegmentMap map;

  Segment at(double x, double y) const { return map.segment(map.id_at(x, y)); }
};

Drawn draw(const StreetPlan& plan, double cell = 0.1) {
  Drawn drawn;
  auto bytes = rasterise(plan, {.cell_size = cell}, "test");
  EXPECT_TRUE(bytes);
  if (!bytes) return drawn;
  drawn.bytes = std::move(*bytes);
  const auto map = SegmentMap::open(drawn.bytes, "test");
  EXPECT_TRUE(map);
  if (map) drawn.map = *map;
  return drawn;
}

StreetPlan one_street() {
  StreetPlan plan;
  plan.strips.push_back({{SegmentKind::kCarriageway, 7}, {{-30, 5}, {30, 5}}, 3, 0.4, 2, 2});
  return plan;
}

TEST(Rasterise, DrawsAStreetWithItsWidth) {
  const Drawn drawn = draw(one_street());
  for (double x = -29.95; x < 30; x += 0.73) {
    for (double y = -5; y < 15; y += 0.07) {
      const double edge = std::abs(y - 5) - 3;
      const SegmentKind expected = edge < 0     ? SegmentKind::kCarriageway
                                   : edge < 0.4 ? SegmentKind::kKerb
                                   : edge < 2.4 ? SegmentKind::kSidewalk
                                                : SegmentKind::kOpenLand;
      // The centre of a cell decides: tolerance of 5 cm on either side of an edge.
      const bool doubtful =
          std::abs(edge) < 0.06 || std::abs(edge - 0.4) < 0.06 || std::abs(edge - 2.4) < 0.06;
      if (doubtful) continue;
      ASSERT_EQ(drawn.at(x, y).kind, expected) << x << " " << y;
    }
  }
  EXPECT_EQ(drawn.at(0, 5).osm_id, 7);
  EXPECT_EQ(drawn.at(0, 8.2).osm_id, 7);
}

TEST(Rasterise, HasNoKerbWhereStreetsMeet) {
  StreetPlan plan = one_street();
  plan.strips.push_back({{SegmentKind::kCarriageway, 8}, {{0, 5}, {0, 60}}, 2.5, 0.4});
  const Drawn drawn = draw(plan);
  for (double y = 2.1; y < 59; y += 0.1) {
    EXPECT_EQ(drawn.at(0, y).kind, SegmentKind::kCarriageway) << y;
  }
  EXPECT_EQ(drawn.at(2.7, 30).kind, SegmentKind::kKerb);
  EXPECT_EQ(drawn.at(2.7, 30).osm_id, 8);
  EXPECT_EQ(drawn.at(0, 30).osm_id, 8);
  EXPECT_EQ(drawn.at(-2.7, 8.2).kind, SegmentKind::kKerb);  // of the first, beside the junction
}

TEST(Rasterise, LayersAreInOrder) {
  StreetPlan plan = one_street();
  const Polyline park{{-20, -20}, {20, -20}, {20, 20}, {-20, 20}};
  const Polyline pond{{5, 12}, {9, 12}, {9, 16}, {5, 16}};
  plan.areas.push_back({{SegmentKind::kWater, 3}, {pond}});
  plan.areas.push_back({{SegmentKind::kGreen, 2}, {park}});  // larger, but later in the plan
  plan.strips.push_back({{SegmentKind::kFootway, 4}, {{-10, -15}, {-10, 25}}, 1});
  plan.strips.push_back({{SegmentKind::kCrossing, 5}, {{10, 2}, {10, 8}}, 2});
  const Drawn drawn = draw(plan);
  EXPECT_EQ(drawn.at(7, 14).kind, SegmentKind::kWater);
  EXPECT_EQ(drawn.at(-15, 15).kind, SegmentKind::kGreen);
  EXPECT_EQ(drawn.at(-10, 15).kind, SegmentKind::kFootway);
  EXPECT_EQ(drawn.at(-10, 5).kind, SegmentKind::kCarriageway);
  EXPECT_EQ(drawn.at(-10, 9).kind, SegmentKind::kFootway);  // over the pavement
  EXPECT_EQ(drawn.at(10, 5).kind, SegmentKind::kCrossing);
  EXPECT_NE(drawn.at(10, 9).kind, SegmentKind::kCrossing);  // only on the carriageway
}

TEST(Rasterise, PavementsLieOnTheirSideOfTheStreet) {
  StreetPlan plan;  // eastwards: left is north
  plan.strips.push_back({{SegmentKind::kCarriageway, 7}, {{-30, 5}, {30, 5}}, 3, 0.4, 0, 2});
  const Drawn drawn = draw(plan);
  EXPECT_EQ(drawn.at(0, 8.2).kind, SegmentKind::kKerb);
  EXPECT_EQ(drawn.at(0, 1.8).kind, SegmentKind::kKerb);
  EXPECT_EQ(drawn.at(0, 9.4).kind, SegmentKind::kOpenLand);
  EXPECT_EQ(drawn.at(0, 0.6).kind, SegmentKind::kSidewalk);
}

TEST(Rasterise, AnOverpassMakesNoJunction) {
  StreetPlan plan = one_street();  // below
  PlanStrip ramp{{SegmentKind::kCarriageway, 8}, {{0, -60}, {0, -20}}, 2.5, 0.4};
  PlanStrip bridge{{SegmentKind::kCarriageway, 9}, {{0, -20}, {0, 40}}, 2.5, 0.4};
  bridge.layer = 1;
  plan.strips.push_back(bridge);
  plan.strips.push_back(ramp);
  const Drawn drawn = draw(plan);
  for (double y = -59; y < 39; y += 0.1) {  // kerbs all along the bridge, none across it
    if (std::abs(y + 20) < 0.3) continue;
    EXPECT_EQ(drawn.at(0, y).kind, SegmentKind::kCarriageway) << y;
    EXPECT_EQ(drawn.at(0, y).osm_id, y < -20 ? 8 : 9) << y;
    for (const double x : {-2.7, 2.7}) EXPECT_EQ(drawn.at(x, y).kind, SegmentKind::kKerb) << y;
  }
  EXPECT_EQ(drawn.at(0, -20.2).kind, SegmentKind::kCarriageway);
  EXPECT_EQ(drawn.at(5, 5).osm_id, 7);
}

TEST(Rasterise, StreetsBelowAndJointsOfLevelsAreMarked) {
  StreetPlan plan = one_street();  // along y = 5, below the bridge
  PlanStrip ramp{{SegmentKind::kCarriageway, 8}, {{0, -60}, {0, -20}}, 2.5, 0.4};
  PlanStrip bridge{{SegmentKind::kCarriageway, 9}, {{0, -20}, {0, 40}}, 2.5, 0.4};
  PlanStrip tunnel{{SegmentKind::kCarriageway, 10}, {{-20, -60}, {-20, 40}}, 2.5, 0.4};
  bridge.layer = 1;
  tunnel.tunnel = true;
  plan.strips.insert(plan.strips.end(), {ramp, bridge, tunnel});
  plan.areas.push_back(
      {{SegmentKind::kBuilding, 30}, {{{-24, 20}, {-16, 20}, {-16, 30}, {-24, 30}}}});
  const Drawn drawn = draw(plan);
  const auto expect = [&](double x, double y, Segment segment) {
    EXPECT_EQ(drawn.at(x, y), segment) << x << ' ' << y;
  };
  using enum StreetLevels;
  using enum SegmentKind;
  expect(0, 5, {kCarriageway, 9, 1, kBelow});
  expect(2.7, 5, {kKerb, 9, 1, kBelow});
  expect(5, 5, {kCarriageway, 7, 0, kOne});
  expect(0, -5, {kCarriageway, 9, 1, kOne});
  expect(0, -17, {kCarriageway, 9, 1, kJoined});
  expect(0, -23, {kCarriageway, 8, 0, kJoined});
  expect(0, -30, {kCarriageway, 8, 0, kOne});
  expect(0, -12, {kCarriageway, 9, 1, kOne});  // the end of the ramp lies under the bridge
  expect(-20, 5, {kCarriageway, 7, 0, kBelow});
  expect(-20, -20, {kOpenLand, 0, 0, kBelow});
  expect(-20, 25, {kBuilding, 30, 0, kBelow});
  expect(-15, -20, {});
}

TEST(Rasterise, WaterLiesOnTheRightOfACoast) {
  StreetPlan plan = one_street();
  plan.strips.push_back({{SegmentKind::kWater, 6}, {{60, -8}, {0, -8}, {0, -20}, {-60, -20}}, 80});
  const Drawn drawn = draw(plan);
  for (double x = -29; x < 30; x += 1.7) {
    for (double y = -25; y < 0; y += 0.9) {
      const double shore = x > 0 ? -8 : -20;
      if (std::abs(y - shore) < 0.1 || std::abs(x) < 0.1 || y < -19) continue;
      ASSERT_EQ(drawn.at(x, y).kind == SegmentKind::kWater, y > shore) << x << " " << y;
    }
  }
}

TEST(Rasterise, DrawsOnlyTheCorridorOfTheStreets) {
  StreetPlan plan = one_street();
  PlanStrip far = plan.strips[0];
  for (Eigen::Vector2d& point : far.points) point += Eigen::Vector2d(9000, 7000);
  plan.strips.push_back(far);
  const auto size = rasterise(plan, {}, "")->size();
  plan.areas.push_back(
      {{SegmentKind::kGreen, 2}, {{{-1e4, -1e4}, {2e4, -1e4}, {2e4, 2e4}, {-1e4, 2e4}}}});
  const Drawn drawn = draw(plan, 0.2);
  EXPECT_EQ(drawn.at(0, 50).kind, SegmentKind::kGreen);
  EXPECT_EQ(drawn.at(9000, 6950).kind, SegmentKind::kGreen);
  EXPECT_EQ(drawn.at(5000, 3500).kind, SegmentKind::kOpenLand);
  EXPECT_LT(drawn.bytes.size(), 1.5 * static_cast<double>(size));
  plan.limit = {Eigen::Vector2d(-50, -50), Eigen::Vector2d(50, 50)};
  const Drawn limited = draw(plan, 0.2);
  EXPECT_LT(limited.map.columns() * 0.2, 130);
  EXPECT_EQ(limited.at(0, 5).kind, SegmentKind::kCarriageway);
  EXPECT_EQ(limited.at(9000, 7005).kind, SegmentKind::kOpenLand);
}

TEST(Rasterise, BuildingsHaveWallsAndYards) {
  StreetPlan plan = one_street();
  const Polyline outline{{-8, 12}, {8, 12}, {8, 28}, {-8, 28}};
  const Polyline yard{{-3, 17}, {3, 17}, {3, 23}, {-3, 23}};
  plan.areas.push_back({{SegmentKind::kBuilding, 9}, {outline, yard}, 0.8});
  const Drawn drawn = draw(plan);
  EXPECT_EQ(drawn.at(-5, 20).kind, SegmentKind::kBuilding);
  EXPECT_EQ(drawn.at(0, 20).kind, SegmentKind::kOpenLand);
  for (const double y : {11.7, 12.0, 12.3}) EXPECT_EQ(drawn.at(0, y).kind, SegmentKind::kWall);
  EXPECT_EQ(drawn.at(-3.2, 20).kind, SegmentKind::kWall);
  EXPECT_EQ(drawn.at(0, 11.5).kind, SegmentKind::kOpenLand);
}

TEST(Rasterise, CellsAgreeAcrossTilesAndWithTheOracle) {
  // A ring with many corners against the definition, over several tiles.
  StreetPlan plan;
  Polyline ring;
  for (int i = 0; i < 97; ++i) {
    const double a = 2 * M_PI * i / 97, r = i % 2 == 0 ? 22 : 14;
    ring.push_back(r * Eigen::Vector2d(std::cos(a), std::sin(a)));
  }
  plan.areas.push_back({{SegmentKind::kGreen, 1}, {ring}});
  const Drawn drawn = draw(plan, 0.2);
  int inside = 0;
  for (int row = 0; row < drawn.map.rows(); ++row) {
    for (int column = 0; column < drawn.map.columns(); ++column) {
      const Eigen::Vector2d p =
          drawn.map.frame().min_corner + 0.2 * Eigen::Vector2d(column + 0.5, row + 0.5);
      double turned = 0;  // winding number
      for (size_t i = 0; i < ring.size(); ++i) {
        const Eigen::Vector2d a = ring[i] - p, b = ring[(i + 1) % ring.size()] - p;
        turned += std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
      }
      const bool in = std::abs(turned) > M_PI;
      inside += in;
      ASSERT_EQ(drawn.map.id_of_cell(column, row) != 0, in) << column << " " << row;
    }
  }
  EXPECT_NEAR(inside * 0.04, signed_area(ring), 5);
}

TEST(Rasterise, RejectsEmptyOrTooLargePlans) {
  EXPECT_FALSE(rasterise({}, {}, ""));
  StreetPlan plan = one_street();
  plan.strips[0].points[1].x() = 3e6;
  const auto large = rasterise(plan, {}, "");
  ASSERT_FALSE(large);
  EXPECT_NE(large.error().what.find("3000 km"), std::string::npos);
  EXPECT_TRUE(RasterOptions{.cell_size = 0}.invalid());
  EXPECT_FALSE(RasterOptions{}.invalid());
}

TEST(Rasterise, StatesTheAreaBeforeItDraws) {
  StreetPlan plan = one_street();
  plan.strips[0].points[1] = {60000, 5};
  int steps = 0;
  const auto large = rasterise(plan, {.max_area = 1e6}, "", [&](double) { ++steps; });
  ASSERT_FALSE(large);
  EXPECT_NE(large.error().what.find("cover 4 km², more than the limit of 1 km²"),
            std::string::npos);
  EXPECT_EQ(steps, 0);
}

TEST(StreetPlan, FindsRingsThatCrossThemselves) {
  EXPECT_FALSE(crosses_itself({{0, 0}, {4, 0}, {4, 4}, {0, 4}}));
  EXPECT_FALSE(crosses_itself({{0, 0}, {4, 0}, {4, 4}}));
  EXPECT_FALSE(crosses_itself({{0, 0}, {4, 0}, {4, 4}, {2, 1}, {0, 4}}));
  EXPECT_TRUE(crosses_itself({{0, 0}, {4, 4}, {4, 0}, {0, 4}}));          // figure of eight
  EXPECT_TRUE(crosses_itself({{0, 0}, {4, 0}, {4, 4}, {2, 0}, {0, 4}}));  // touches an edge
  EXPECT_TRUE(crosses_itself({{0, 0}, {4, 0}, {4, 4}, {2, -1}, {0, 4}}));
}

TEST(MapImage, IsNorthUp) {
  const Drawn drawn = draw(one_street(), 0.2);
  const CameraFrame image = draw_map(drawn.map);
  ASSERT_EQ(image.width, drawn.map.columns());
  ASSERT_EQ(image.pixels.size(), image.row_bytes() * static_cast<size_t>(image.height));
  const auto pixel = [&](double x, double y) {
    const auto column = static_cast<size_t>((x - drawn.map.frame().min_corner.x()) / 0.2);
    const auto row = static_cast<size_t>((y - drawn.map.frame().min_corner.y()) / 0.2);
    return image
        .pixels[(static_cast<size_t>(image.height) - 1 - row) * image.row_bytes() + column * 3];
  };
  EXPECT_NE(pixel(0, 5), pixel(0, -5));
  EXPECT_EQ(pixel(0, 5), pixel(10, 4));
  EXPECT_EQ(draw_map(drawn.map, 50).width, drawn.map.columns() / ((drawn.map.columns() + 49) / 50));
}

}  // namespace
}  // namespace infuse::streetmap
