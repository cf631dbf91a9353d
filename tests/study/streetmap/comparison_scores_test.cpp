#include "tests/study/streetmap/comparison_scores.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fusion/dependence/prepared_dependence.hpp"
#include "tests/fusion/streetmap/labelled_view.hpp"

namespace infuse::streetmap {
namespace {

using town::kFit, town::LabelledView;

TEST(BaggedLsmiScore, IsTheMeanOverItsBags) {
  LabelledView view;
  const dependence::HyperParameters fixed{2.0, 1e-3};
  BaggedLsmiScore score(kFit);
  EXPECT_STREQ(score.prepare(view.samples), "");
  double sum = 0;
  for (size_t b = 0; b < 4; ++b) {
    std::vector<int32_t> labels;
    Eigen::MatrixXd part(view.samples.size() / 4, 3);
    for (size_t i = 0; i < view.samples.size() / 4; ++i) {
      labels.push_back(view.labels[i * 4 + b]);
      part.row(static_cast<Eigen::Index>(i)) =
          view.samples.features.matrix().row(static_cast<Eigen::Index>(i * 4 + b));
    }
    dependence::PreparedDependence bag(dependence::FitMeasure::kSmi, part, kFit);
    sum += bag.evaluate(labels, view.window.label_count(), fixed).value;
  }
  EXPECT_NEAR(score.evaluate(view.labels, view.window, fixed), sum / 4, 1e-9);
}

// I(3.7) by hand: gradients and discontinuities from 0 on, some samples on kerbs.
TEST(BoundaryScore, IsTheCorrelationOfI37) {
  LabelledView view;
  GridSamples& samples = view.samples;
  const auto n = static_cast<Eigen::Index>(samples.size());
  samples.features.resize(n, kFeatureCount);
  double sum = 0, squares = 0, kerbs = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index f = 0; f < kFeatureCount; ++f) samples.features(i, f) = 0;
    const auto g = static_cast<double>(i % 3), d = static_cast<double>(i % 4);
    samples.features(i, kGradient) = g - 0.7;
    samples.features(i, kDiscontinuity) = d - 1.3;
    const bool kerb = view.window.kind(view.labels[static_cast<size_t>(i)]) == SegmentKind::kKerb;
    sum += kerb ? g * d : 0;
    squares += g * d * g * d;
    kerbs += kerb;
  }
  ASSERT_GT(kerbs, 3);
  BoundaryScore score;
  EXPECT_STREQ(score.prepare(samples), "");
  EXPECT_NEAR(score.evaluate(view.labels, view.window, {}), sum / std::sqrt(squares * kerbs),
              1e-12);
}

TEST(ComparisonScores, ReportWhyAViewCannotBeEvaluated) {
  EXPECT_STRNE(BaggedLsmiScore(kFit).prepare(GridSamples{}), "");
  EXPECT_STREQ(BoundaryScore().prepare(LabelledView().samples),
               "the boundary measure needs colours");
}

}  // namespace
}  // namespace infuse::streetmap
