#include "fusion/streetmap/view_score.hpp"

#include <gtest/gtest.h>

#include "fusion/dependence/prepared_dependence.hpp"
#include "tests/fusion/streetmap/labelled_view.hpp"

namespace infuse::streetmap {
namespace {

using town::kFit, town::LabelledView;

TEST(LsmiScore, EqualsPreparedDependence) {
  LabelledView view;
  LsmiScore score(kFit);
  EXPECT_STREQ(score.prepare(view.samples), "");
  dependence::HyperParameters chosen;
  const double found = score.evaluate(view.labels, view.window, {}, &chosen);
  dependence::PreparedDependence prepared(dependence::FitMeasure::kSmi,
                                          view.samples.features.matrix(), kFit);
  const auto expected = prepared.evaluate(view.labels, view.window.label_count());
  EXPECT_NEAR(found, expected.value, 1e-9);
  EXPECT_EQ(chosen, expected.hyper_parameters);
  EXPECT_GT(found, 0.1);
}

TEST(LsmiScore, ReportsWhyAViewCannotBeEvaluated) {
  EXPECT_STRNE(LsmiScore(kFit).prepare(GridSamples{}), "");
}

}  // namespace
}  // namespace infuse::streetmap
