// Two drives along one street, of which the second is seen in a frame of its own.

#include "fusion/mapping/drive_join.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace infuse::mapping {
namespace {

constexpr size_t kOfEach = 60;  // keyframes
constexpr double kApart = 2;    // m
const std::vector<size_t> kFirst{0, kOfEach};

/// True poses along a bent street, driven twice, the second time the other way.
std::vector<Eigen::Isometry3d> street_twice() {
  std::vector<Eigen::Isometry3d> poses;
  for (size_t k = 0; k < kOfEach; ++k) {
    const double x = kApart * static_cast<double>(k);
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() << x, 10 * std::sin(0.03 * x), 0;
    T.linear() = Eigen::AngleAxisd(std::atan(0.3 * std::cos(0.03 * x)), Eigen::Vector3d::UnitZ())
                     .toRotationMatrix();
    poses.push_back(T);
  }
  const Eigen::Isometry3d turned(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ()));
  for (size_t k = 0; k < kOfEach; ++k) poses.push_back(poses[kOfEach - 1 - k] * turned);
  return poses;
}

/// Odometry with a heading that drifts by 1 mrad a keyframe, and states it.
std::vector<Keyframe> keyframes_of(const std::vector<Eigen::Isometry3d>& truth) {
  std::vector<Keyframe> keyframes(truth.size());
  for (size_t k = 0; k < truth.size(); ++k) {
    keyframes[k].distance_driven = kApart * static_cast<double>(k);
    if (k % kOfEach == 0) continue;
    keyframes[k].T_odom_vehicle = keyframes[k - 1].T_odom_vehicle * truth[k - 1].inverse() *
                                  truth[k] * Eigen::AngleAxisd(1e-3, Eigen::Vector3d::UnitZ());
    geometry::Vector6 variance;
    variance << 1e-6, 1e-6, 1e-6, 1e-4, 1e-4, 1e-4;
    keyframes[k].covariance = variance.asDiagonal();
  }
  return keyframes;
}

Closure closure_of(const std::vector<Eigen::Isometry3d>& truth, size_t from, size_t to,
                   double wrong_by = 0) {
  Closure closure;
  closure.from = from;
  closure.to = to;
  closure.T_from_to = truth[from].inverse() * truth[to];
  closure.T_from_to.translation().x() += wrong_by;
  closure.covariance = geometry::Matrix6::Identity() * 1e-3;
  return closure;
}

TEST(DriveJoin, TrueClosuresAgreeAndFalseOnesAreLeftOut) {
  const auto truth = street_twice();
  const auto keyframes = keyframes_of(truth);
  std::vector<Closure> closures;
  for (const size_t k : {50U, 10U, 22U, 34U}) {
    closures.push_back(closure_of(truth, kOfEach - 1 - k, kOfEach + k));
    closures.push_back(closure_of(truth, k, kOfEach + k, 15 + static_cast<double>(k)));
  }
  closures.push_back(closure_of(truth, 5, kOfEach + 54));
  closures.back().reason = "rejected";
  EXPECT_EQ(find_agreeing(keyframes, kFirst, closures), (std::vector<size_t>{2, 4, 6, 0}));
}

TEST(DriveJoin, TooFewOrTwoOpinionsJoinNothing) {
  const auto truth = street_twice();
  const auto keyframes = keyframes_of(truth);
  const auto matching = [&](size_t k, double wrong_by) {
    return closure_of(truth, kOfEach - 1 - k, kOfEach + k, wrong_by);
  };
  EXPECT_TRUE(find_agreeing(keyframes, kFirst, {matching(10, 0), matching(30, 0)}).empty());
  // Three of one place are one.
  EXPECT_TRUE(find_agreeing(keyframes, kFirst, {matching(10, 0), matching(10, 0), matching(10, 0)})
                  .empty());
  // On a straight street three that are wrong by the same length agree as well.
  std::vector<Eigen::Isometry3d> straight(2 * kOfEach, Eigen::Isometry3d::Identity());
  for (size_t k = 0; k < straight.size(); ++k) {
    straight[k].translation().x() = kApart * static_cast<double>(k % kOfEach);
  }
  const auto along = keyframes_of(straight);
  std::vector<Closure> closures;
  for (const size_t k : {10U, 20U, 30U}) {
    closures.push_back(closure_of(straight, k, kOfEach + k));
    closures.push_back(closure_of(straight, k, kOfEach + k, 25));
  }
  EXPECT_TRUE(find_agreeing(along, kFirst, closures).empty());
}

TEST(DriveJoin, OdometryBetweenIsTheSameEitherWay) {
  const auto keyframes = keyframes_of(street_twice());
  const OdometryBetween there = odometry_between(keyframes, 5, 40);
  const OdometryBetween back = odometry_between(keyframes, 40, 5);
  EXPECT_TRUE((there.T_from_to * back.T_from_to).isApprox(Eigen::Isometry3d::Identity(), 1e-9));
  EXPECT_TRUE(geometry::transform_covariance(there.T_from_to, back.covariance)
                  .isApprox(there.covariance, 1e-9));
  EXPECT_TRUE(there.T_from_to.isApprox(
      keyframes[5].T_odom_vehicle.inverse() * keyframes[40].T_odom_vehicle, 1e-9));
}

// The search goes on from where the drive joins, and closes every few metres.
TEST(DriveJoin, TheSearchFindsTheRestOfTheStreet) {
  const auto truth = street_twice();
  const auto keyframes = keyframes_of(truth);
  const DriveJoin join{kOfEach, {closure_of(truth, 49, kOfEach + 10)}};
  const auto verify = [&](Closure& closure) -> Result<void> {
    const Eigen::Vector3d guess = closure.T_from_to.translation();
    closure = closure_of(truth, closure.from, closure.to);
    if ((closure.T_from_to.translation() - guess).norm() > 2) closure.reason = "not found";
    return {};
  };
  const auto found = search_closures(keyframes, {join}, {}, {}, {}, verify);
  ASSERT_TRUE(found);
  size_t accepted = 0;
  for (const Closure& closure : *found) {
    if (!closure.accepted()) continue;
    ++accepted;
    EXPECT_LT(closure.from, kOfEach);
    EXPECT_GE(closure.to, kOfEach);
  }
  EXPECT_GE(accepted, kOfEach / 3);
}

// The street thrice: the second drive is linked with the third alone, and that with the first.
TEST(DriveJoin, ADriveJoinsThroughALaterOne) {
  auto truth = street_twice();
  truth.insert(truth.end(), truth.begin(), truth.begin() + kOfEach);
  auto keyframes = keyframes_of(truth);
  for (size_t k = 1; k < keyframes.size(); ++k) {  // without drift
    keyframes[k].T_odom_vehicle = truth[k];
    if (k >= kOfEach && k < 2 * kOfEach)
      keyframes[k].T_odom_vehicle = truth[kOfEach].inverse() * truth[k];
  }
  const std::vector<size_t> first{0, kOfEach, 2 * kOfEach};
  std::vector<Closure> links{closure_of(truth, kOfEach + 40, 2 * kOfEach + 18)};
  EXPECT_FALSE(join_by_links(keyframes, first, links, 1));
  EXPECT_EQ(find_linked_drives(keyframes, first, links, 1), (std::vector<bool>{false, true, true}));
  EXPECT_EQ(find_linked_drives(keyframes, first, {}, 1), (std::vector<bool>{false, true, false}));
  links.push_back(closure_of(truth, 30, 2 * kOfEach + 31));
  const auto join = join_by_links(keyframes, first, links, 1);
  ASSERT_TRUE(join);
  EXPECT_EQ(join->first, kOfEach);
  ASSERT_EQ(join->closures.size(), 1U);
  const Closure& composed = join->closures.front();
  EXPECT_EQ(composed.from, 30U);
  EXPECT_EQ(composed.to, kOfEach);
  EXPECT_TRUE(composed.T_from_to.isApprox(truth[30].inverse() * truth[kOfEach], 1e-9));
  // As the steps from the first drive on add up: two closures, 13 and 40 keyframes of odometry.
  geometry::Matrix6 expected = links[1].covariance;
  Eigen::Isometry3d T = links[1].T_from_to;
  const auto add = [&](const Eigen::Isometry3d& step, const geometry::Matrix6& covariance) {
    expected += geometry::transform_covariance(T, covariance);
    T = T * step;
  };
  const OdometryBetween third = odometry_between(keyframes, 2 * kOfEach + 31, 2 * kOfEach + 18);
  add(third.T_from_to, third.covariance);
  const Eigen::Isometry3d T_third_second = links[0].T_from_to.inverse();
  add(T_third_second, geometry::transform_covariance(T_third_second, links[0].covariance));
  const OdometryBetween second = odometry_between(keyframes, kOfEach + 40, kOfEach);
  add(second.T_from_to, second.covariance);
  EXPECT_TRUE(composed.covariance.isApprox(expected, 1e-9));
  // Straight links come first, in order of `to`.
  links.push_back(closure_of(truth, 9, kOfEach + 50));
  links.push_back(closure_of(truth, 29, kOfEach + 30));
  const auto straight = join_by_links(keyframes, first, links, 1);
  ASSERT_TRUE(straight);
  ASSERT_EQ(straight->closures.size(), 2U);
  EXPECT_EQ(straight->closures.front().to, kOfEach + 30);
}

TEST(DriveJoin, OptionsSayWhatIsWrong) {
  EXPECT_FALSE(AgreementOptions{}.invalid());
  EXPECT_TRUE(AgreementOptions{.min_closures = 1}.invalid());
  EXPECT_TRUE(AgreementOptions{.widening = 0.5}.invalid());
  EXPECT_TRUE(AgreementOptions{.max_rival = 2}.invalid());
}

}  // namespace
}  // namespace infuse::mapping
