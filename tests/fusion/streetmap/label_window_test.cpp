#include "fusion/streetmap/label_window.hpp"

#include <gtest/gtest.h>

#include <map>

#include "tests/fusion/streetmap/town.hpp"

namespace infuse::streetmap {
namespace {

/// Compares every look-up with the map: labels correspond one to one to segments or kinds.
void expect_agrees(Labelling labelling) {
  const town::Town town = town::build(town::plan());
  LabelWindow window;
  window.read(town.map, 5, -3, 40, labelling);
  std::mt19937 random(1);
  std::uniform_real_distribution<float> place(-20, 20);
  std::vector<float> x, y;
  for (int i = 0; i < 3000; ++i) {
    x.push_back(place(random));
    y.push_back(place(random));
  }
  std::map<uint32_t, int32_t> label_of;
  std::map<int32_t, uint32_t> key_of;
  for (const PlanarPose& pose : {PlanarPose{5, -3, 0}, PlanarPose{8, 1, 2.5}}) {
    std::vector<int32_t> labels(x.size());
    window.look_up(pose, x, y, labels);
    for (size_t i = 0; i < x.size(); ++i) {
      const Eigen::Vector2d p = pose.transform({x[i], y[i]});
      // Away from cell edges, where rounding matters.
      const Eigen::Vector2d cell = (p - town.map.frame().min_corner) / 0.2;
      if ((cell - cell.array().round().matrix()).cwiseAbs().minCoeff() < 0.01) continue;
      const uint32_t id = town.map.id_at(p.x(), p.y());
      const uint32_t key =
          labelling == Labelling::kSegments ? id : static_cast<uint32_t>(town.map.segment(id).kind);
      ASSERT_GE(labels[i], 0);
      ASSERT_LT(labels[i], window.label_count());
      ASSERT_EQ(label_of.emplace(key, labels[i]).first->second, labels[i]);
      ASSERT_EQ(key_of.emplace(labels[i], key).first->second, key);
    }
  }
  EXPECT_GT(key_of.size(), 4U);
}

TEST(LabelWindow, AgreesWithTheMapBySegment) { expect_agrees(Labelling::kSegments); }

TEST(LabelWindow, AgreesWithTheMapByKind) { expect_agrees(Labelling::kKinds); }

TEST(LabelWindow, BeyondTheMapIsOpenLand) {
  const town::Town town = town::build(town::plan());
  LabelWindow window;
  window.read(town.map, 1e5, 1e5, 30, Labelling::kKinds);
  EXPECT_EQ(window.label_count(), 1);
  const float x[] = {0, 1000};
  const float y[] = {0, 1000};
  int32_t labels[] = {9, 9};
  window.look_up({1e5, 1e5, 0}, x, y, labels);
  EXPECT_EQ(labels[0], 0);
  EXPECT_EQ(labels[1], 0);
  window.read(town.map, 1e300, -1e300, 30, Labelling::kSegments);  // no overflow
  EXPECT_EQ(window.label_count(), 1);
}

TEST(LabelWindow, ManySegmentsShareTheLastLabel) {
  StreetPlan plan;
  for (int i = 0; i < 400; ++i) {
    const double x = i % 20 * 2.0, y = i / 20 * 2.0;
    plan.areas.push_back(
        {{SegmentKind::kGreen, i}, {{{x, y}, {x + 1, y}, {x + 1, y + 1}, {x, y + 1}}}});
  }
  const town::Town town = town::build(plan);
  LabelWindow window;
  window.read(town.map, 20, 20, 40, Labelling::kSegments);
  EXPECT_EQ(window.label_count(), 255);
}

}  // namespace
}  // namespace infuse::streetmap
