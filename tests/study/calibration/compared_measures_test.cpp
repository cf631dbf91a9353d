#include "tests/study/calibration/compared_measures.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace infuse::study {
namespace {

using calibration::LidarFeature;

TEST(ComparedMeasures, AreAllValidAndFoundByName) {
  for (const calibration::NamedMeasure& measure : compared_measures()) {
    EXPECT_EQ(find_any_measure(measure.name), &measure);
    EXPECT_EQ(calibration::find_measure(measure.name), nullptr);
    for (const auto& term : measure.terms) EXPECT_FALSE(term.invalid()) << measure.name;
  }
  EXPECT_STREQ(find_any_measure("joint")->name, "joint");
  EXPECT_EQ(find_any_measure("telepathy"), nullptr);
}

TEST(LevinsonThrun, IsTheMeanProductOfEdges) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  calibration::VisiblePoints points;
  points.x = points.y = points.z = {1, 1, 1, 1};
  points.lidar[index(LidarFeature::kDiscontinuity)] = {1, 2, kNone, 3};
  const auto term =
      calibration::make_term(find_any_measure("levinson-thrun")->terms.front(), points);
  std::vector<float> gradient(4);
  const auto estimate = term->evaluate(std::vector<float>{0.5F, 0.25F, 1, kNone}, gradient);
  EXPECT_DOUBLE_EQ(estimate.value, 0.25);
  EXPECT_THAT(gradient, testing::ElementsAre(0.25F, 0.5F, 0, 0.75F));
  EXPECT_EQ(term->sample_count(), 4U);
}

}  // namespace
}  // namespace infuse::study
