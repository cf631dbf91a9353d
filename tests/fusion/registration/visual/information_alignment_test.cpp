#include "fusion/registration/visual/information_alignment.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/fusion/registration/visual/invented_codewords.hpp"

namespace infuse::registration {
namespace {

using geometry::Vector6;

constexpr size_t kWords = 30;
const Codebook kCodebook = line_of_words(kWords);

Eigen::Isometry3d motion(double x, double y, double heading) {
  return Eigen::Translation3d(x, y, 0.1) * Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitY());
}

TEST(InformationAlignment, FindsMotionsWithoutAGuess) {
  std::mt19937 random(1);
  for (const Eigen::Isometry3d& truth :
       {motion(1, 0, 0), motion(9, -2, 0.4), motion(-6, 5, -0.6), motion(-4, 3, 2.6)}) {
    const CodewordCloud target = draw_codewords(300, kWords, random);
    const CodewordCloud source = see_again(target, truth, kWords, 0.05F, 0.4, random);
    const RegistrationResult result = align_by_information(kCodebook, target, source);
    EXPECT_TRUE(result.usable()) << result.reason;
    const Vector6 error = geometry::log(result.T_target_source * truth.inverse());
    EXPECT_LT(error.head<3>().norm(), 0.01);
    EXPECT_LT((result.T_target_source.translation() - truth.translation()).norm(), 0.1);
  }
}

TEST(InformationAlignment, SimplexFindsANearMotionOnly) {
  std::mt19937 random(1);
  const CodewordCloud target = draw_codewords(300, kWords, random);
  const InformationAlignmentOptions simplex{.optimizer = InformationOptimizer::kSimplex};
  const CodewordCloud near = see_again(target, motion(0.7, 0.2, 0.02), kWords, 0.05F, 0.3, random);
  const RegistrationResult result = align_by_information(kCodebook, target, near, simplex);
  EXPECT_TRUE(result.usable()) << result.reason;
  EXPECT_LT((result.T_target_source.translation() - Eigen::Vector3d(0.7, 0.2, 0.1)).norm(), 0.1);
}

TEST(InformationAlignment, CovarianceIsHonest) {
  std::mt19937 random(5);
  InformationAlignmentOptions options{.max_distance = 4, .max_heading = 0.2, .candidates = 3};
  double normalised = 0;
  constexpr int kTrials = 30;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Eigen::Isometry3d truth = motion(2, 0.5, 0.05);
    const CodewordCloud target = draw_codewords(250, kWords, random);
    const CodewordCloud source = see_again(target, truth, kWords, 0.06F, 0.3, random);
    const RegistrationResult result = align_by_information(kCodebook, target, source, options);
    ASSERT_TRUE(result.usable()) << result.reason;
    const Vector6 error = geometry::log(truth * result.T_target_source.inverse());
    normalised += error.dot(result.information * error) / 6 / kTrials;
  }
  EXPECT_GT(normalised, 0.5);
  EXPECT_LT(normalised, 2);
}

TEST(InformationAlignment, StatesAReasonWhereItKnowsNoPose) {
  std::mt19937 random(6);
  const InformationAlignmentOptions options{.max_distance = 4, .max_heading = 0.2, .candidates = 3};
  const auto reason = [&](const CodewordCloud& target, const CodewordCloud& source) {
    const RegistrationResult result = align_by_information(kCodebook, target, source, options);
    EXPECT_FALSE(result.usable());
    EXPECT_TRUE(result.T_target_source.matrix().allFinite());
    EXPECT_TRUE(result.covariance.allFinite());
    return std::string(result.reason);
  };
  const CodewordCloud cloud = draw_codewords(300, kWords, random);
  EXPECT_THAT(reason({}, {}), testing::HasSubstr("too few codewords"));
  EXPECT_THAT(reason(cloud, draw_codewords(10, kWords, random)),
              testing::HasSubstr("too few codewords"));
  CodewordCloud none = cloud, one = cloud, far = cloud;
  none.points.setConstant(NAN);
  EXPECT_THAT(reason(cloud, none), testing::HasSubstr("too few codewords"));
  one.points.setZero();
  EXPECT_NE(reason(one, one), "");
  far.points.row(0).array() += 1000;
  EXPECT_THAT(reason(cloud, far), testing::HasSubstr("too few codewords"));
  // Unrelated scans of the same place.
  EXPECT_NE(reason(cloud, draw_codewords(300, kWords, random)), "");
}

TEST(InformationAlignment, AmbiguousScansAreNotUsable) {
  // The same word every 2 m along a line of posts: shifted by one post it is nearly the same.
  CodewordCloud posts;
  posts.points.resize(3, 400);
  for (int i = 0; i < 400; ++i) {
    posts.points.col(i) =
        Eigen::Vector3f(2.0F * float(i / 4) - 100, i % 2 == 0 ? 6.F : -6.F, i % 4 < 2 ? 0.F : 2.F);
    posts.words.push_back(static_cast<uint32_t>(i % 4));
  }
  const RegistrationResult result =
      align_by_information(kCodebook, posts, posts, {.max_heading = 0.8});
  EXPECT_FALSE(result.usable());
  EXPECT_THAT(result.reason, testing::HasSubstr("another pose"));
}

TEST(InformationAlignment, OptionsNameWhatIsWrong) {
  using Options = InformationAlignmentOptions;
  EXPECT_FALSE(Options().invalid());
  EXPECT_TRUE(Options{.fine_radius = 0}.invalid());
  EXPECT_TRUE((Options{.coarse_radius = 1, .fine_radius = 2}.invalid()));
  EXPECT_TRUE(Options{.max_distance = 1e9}.invalid());
  EXPECT_TRUE(Options{.max_heading = NAN}.invalid());
  EXPECT_TRUE(Options{.candidates = 0}.invalid());
  EXPECT_TRUE(Options{.max_runner_up = 0}.invalid());
}

}  // namespace
}  // namespace infuse::registration
