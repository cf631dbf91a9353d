#include "fusion/dependence/sample_choice.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>

namespace infuse::dependence {
namespace {

TEST(SampleChoice, SubsetsAreDistinctAscendingAndEquallyLikely) {
  Random random(1);
  std::vector<int> times(10, 0);
  for (int trial = 0; trial < 5000; ++trial) {
    const std::vector<int> subset = choose_subset(10, 3, random);
    ASSERT_EQ(subset.size(), 3U);
    ASSERT_TRUE(std::is_sorted(subset.begin(), subset.end()));
    ASSERT_EQ(std::set<int>(subset.begin(), subset.end()).size(), 3U);
    for (const int i : subset) ++times.at(static_cast<size_t>(i));
  }
  // Each index: binomial(5000, 0.3), standard deviation 32.
  for (const int count : times) EXPECT_NEAR(count, 1500, 160);
}

TEST(SampleChoice, SubsetIsAllWhenCountIsTooLarge) {
  Random random(1);
  EXPECT_EQ(choose_subset(3, 3, random), (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(choose_subset(3, 9, random), (std::vector<int>{0, 1, 2}));
}

TEST(SampleChoice, FoldsSplitTheSamplesEvenly) {
  Random random(2);
  const Folds folds = make_folds(23, 5, random);
  ASSERT_EQ(folds.count(), 5);
  EXPECT_EQ(std::set<int>(folds.order.begin(), folds.order.end()).size(), 23U);
  for (int f = 0; f < 5; ++f) EXPECT_TRUE(folds.size(f) == 4 || folds.size(f) == 5);
  EXPECT_FALSE(std::is_sorted(folds.order.begin(), folds.order.end()));
}

TEST(SampleChoice, CheckSamplesReportsTheReason) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  Eigen::MatrixXd x(3, 1), y(4, 1);
  x << 1, 2, 3;
  y << 1, 2, 3, 4;
  EXPECT_STREQ(check_samples(x), "");
  EXPECT_STREQ(check_samples(Eigen::MatrixXd(0, 1)), "fewer than two samples");
  EXPECT_STREQ(check_samples(Eigen::MatrixXd(3, 0)), "fewer than two samples");
  EXPECT_STREQ(check_samples(Eigen::MatrixXd::Ones(3, 2)), "all samples are equal");
  EXPECT_STREQ(check_paired_samples(x, y), "the two sides differ in length");
  for (const double bad : {kNan, std::numeric_limits<double>::infinity(), -1e101}) {
    y(2) = bad;
    EXPECT_STREQ(check_samples(y), "a sample is not finite");
  }
}

TEST(SampleChoice, CheckLabelsReportsTheReason) {
  const std::vector<int32_t> good = {0, 1, 2}, alike = {1, 1, 1}, negative = {0, -1, 2};
  EXPECT_STREQ(check_labels(good, 3, 3), "");
  EXPECT_STREQ(check_labels(good, 4, 3), "the two sides differ in length");
  EXPECT_STREQ(check_labels(good, 3, 2), "a label is not between 0 and label_count − 1");
  EXPECT_STREQ(check_labels(negative, 3, 3), "a label is not between 0 and label_count − 1");
  EXPECT_STREQ(check_labels(alike, 3, 3), "all labels are equal");
  EXPECT_STREQ(check_labels(good, 3, 0), "label_count is not between 1 and 10000");
}

}  // namespace
}  // namespace infuse::dependence
