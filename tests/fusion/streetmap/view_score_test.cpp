#include "fusion/streetmap/view_score.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fusion/dependence/prepared_dependence.hpp"
#include "tests/fusion/streetmap/town.hpp"

namespace infuse::streetmap {
namespace {

const dependence::FitOptions kFit{.centres = 25, .sigmas = {1.0, 2.0}, .lambdas = {1e-3, 1e-1}};

struct LabelledView {
  town::Town town = town::build(town::plan());
  PlanarPose pose{-60, 0, 0};
  GridSamples samples = town::sample_view(town.map, pose, 1);
  LabelWindow window;
  std::vector<int32_t> labels = std::vector<int32_t>(samples.size());

  LabelledView() {
    window.read(town.map, pose.x, pose.y, 60, Labelling::kKinds);
    window.look_up(pose, samples.x, samples.y, labels);
  }
};

TEST(ViewScore, LsmiIsThatOfThePreparedDependence) {
  LabelledView asked;
  ViewScore score(ViewMeasure::kLsmi, kFit);
  EXPECT_STREQ(score.prepare(asked.samples), "");
  dependence::HyperParameters chosen;
  const double found = score.evaluate(asked.labels, asked.window, {}, &chosen);
  dependence::PreparedDependence prepared(dependence::FitMeasure::kSmi,
                                          asked.samples.features.matrix(), kFit);
  const auto expected = prepared.evaluate(asked.labels, asked.window.label_count());
  EXPECT_NEAR(found, expected.value, 1e-9);
  EXPECT_EQ(chosen, expected.hyper_parameters);
  EXPECT_GT(found, 0.1);
}

TEST(ViewScore, BlsmiIsTheMeanOverItsBags) {
  LabelledView asked;
  const dependence::HyperParameters kept{2.0, 1e-3};
  ViewScore score(ViewMeasure::kBlsmi, kFit);
  EXPECT_STREQ(score.prepare(asked.samples), "");
  double sum = 0;
  for (size_t b = 0; b < 4; ++b) {
    std::vector<int32_t> labels;
    Eigen::MatrixXd part(asked.samples.size() / 4, 3);
    for (size_t i = 0; i < asked.samples.size() / 4; ++i) {
      labels.push_back(asked.labels[i * 4 + b]);
      part.row(static_cast<Eigen::Index>(i)) =
          asked.samples.features.matrix().row(static_cast<Eigen::Index>(i * 4 + b));
    }
    dependence::PreparedDependence bag(dependence::FitMeasure::kSmi, part, kFit);
    sum += bag.evaluate(labels, asked.window.label_count(), kept).value;
  }
  EXPECT_NEAR(score.evaluate(asked.labels, asked.window, kept), sum / 4, 1e-9);
}

// I(3.7) by hand: gradients and discontinuities that begin at 0, kerbs where some samples are.
TEST(ViewScore, BoundariesAreACorrelation) {
  LabelledView asked;
  GridSamples& samples = asked.samples;
  const auto n = static_cast<Eigen::Index>(samples.size());
  samples.features.resize(n, kFeatureCount);
  double sum = 0, squares = 0, kerbs = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index f = 0; f < kFeatureCount; ++f) samples.features(i, f) = 0;
    const auto g = static_cast<double>(i % 3), d = static_cast<double>(i % 4);  // from 0 on
    samples.features(i, kGradient) = g - 0.7;
    samples.features(i, kDiscontinuity) = d - 1.3;
    const bool kerb = asked.window.kind(asked.labels[static_cast<size_t>(i)]) == SegmentKind::kKerb;
    sum += kerb ? g * d : 0;
    squares += g * d * g * d;
    kerbs += kerb;
  }
  ASSERT_GT(kerbs, 3);
  ViewScore score(ViewMeasure::kBoundaries, kFit);
  EXPECT_STREQ(score.prepare(samples), "");
  EXPECT_NEAR(score.evaluate(asked.labels, asked.window, {}), sum / std::sqrt(squares * kerbs),
              1e-12);
}

TEST(ViewScore, SaysWhyAViewCannotBeAsked) {
  GridSamples none;
  EXPECT_STRNE(ViewScore(ViewMeasure::kLsmi, kFit).prepare(none), "");
  EXPECT_STRNE(ViewScore(ViewMeasure::kBlsmi, kFit).prepare(none), "");
  const LabelledView asked;
  EXPECT_STREQ(ViewScore(ViewMeasure::kBoundaries, kFit).prepare(asked.samples),
               "the boundary measure needs colours");
}

}  // namespace
}  // namespace infuse::streetmap
