#include "fusion/streetmap/particle_set.hpp"
#include "drivers/measurement/angles.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <vector>

#include "fusion/streetmap/score_significance.hpp"

namespace infuse::streetmap {
namespace {

ParticleOptions noise_free_options() {
  ParticleOptions options;
  options.distance_noise = options.yaw_noise = options.yaw_noise_per_update = 0;
  options.scale_sigma = options.yaw_rate_bias_sigma = 0;
  options.kernel_width = options.jitter = options.jitter_yaw = 0;
  return options;
}

TEST(ParticleSet, ScattersByTheCovariance) {
  ParticleOptions options = noise_free_options();
  options.min_count = options.max_count = 20000;
  ParticleSet set(options, 1);
  Eigen::Matrix3d C;
  C << 4, 1, 0.05, 1, 1, 0, 0.05, 0, 0.01;
  set.scatter({10, 20, 3.1}, C);  // yaw wraps around
  const PoseMoments moments = set.moments();
  EXPECT_NEAR(moments.mean.x, 10, 0.06);
  EXPECT_NEAR(moments.mean.y, 20, 0.03);
  EXPECT_NEAR(wrap_angle(moments.mean.yaw - 3.1), 0, 0.003);
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(moments.covariance(i, k), C(i, k), 0.04 * std::sqrt(C(i, i) * C(k, k)));
    }
  }
  // The worst direction of the plane: the larger eigenvalue of [4 1; 1 1].
  EXPECT_NEAR(moments.spread(), std::sqrt(2.5 + std::sqrt(3.25)), 0.05);
}

TEST(ParticleSet, MovesInTheVehiclesFrame) {
  ParticleOptions options = noise_free_options();
  options.min_count = options.max_count = 10;
  ParticleSet set(options, 1);
  set.scatter({1, 2, M_PI / 2}, Eigen::Matrix3d::Zero());
  set.predict({3, 1, 0.25}, Eigen::Matrix3d::Zero(), 0.5);
  for (const Particle& particle : set.all()) {
    EXPECT_NEAR(particle.pose.x, 0, 1e-12);
    EXPECT_NEAR(particle.pose.y, 5, 1e-12);
    EXPECT_NEAR(particle.pose.yaw, M_PI / 2 + 0.25, 1e-12);
  }
}

TEST(ParticleSet, MotionNoiseHasItsCovariance) {
  ParticleOptions options = noise_free_options();
  options.min_count = options.max_count = 20000;
  options.distance_noise = 0.1;
  ParticleSet set(options, 3);
  set.scatter({0, 0, 0}, Eigen::Matrix3d::Zero());
  const Eigen::Matrix3d C = Eigen::Vector3d(0.01, 0.04, 1e-4).asDiagonal();
  set.predict({4, 0, 0}, C, 0.5);
  const PoseMoments moments = set.moments();
  EXPECT_NEAR(moments.covariance(0, 0), 0.01 + 0.01 * 4, 0.002);
  EXPECT_NEAR(moments.covariance(1, 1), 0.04 + 0.01 * 4, 0.003);
  EXPECT_NEAR(moments.covariance(2, 2), 1e-4, 4e-6);
}

// A persistent error grows linearly with distance: 100 steps of one metre and 100 s.
TEST(ParticleSet, PersistentErrorsAddUp) {
  ParticleOptions options = noise_free_options();
  options.min_count = options.max_count = 20000;
  options.scale_sigma = 0.01;
  options.yaw_rate_bias_sigma = 0.001;
  options.scale_correlation_distance = options.yaw_rate_bias_correlation_time = 1e7;
  ParticleSet set(options, 8);
  set.scatter({0, 0, 0}, Eigen::Matrix3d::Zero());
  for (int i = 0; i < 100; ++i) set.predict({1, 0, 0}, Eigen::Matrix3d::Zero(), 1);
  const Eigen::Matrix3d C = set.moments().covariance;
  EXPECT_NEAR(std::sqrt(C(0, 0)), 1, 0.05);
  EXPECT_NEAR(std::sqrt(C(2, 2)), 0.1, 0.003);
  EXPECT_NEAR(std::sqrt(C(1, 1)), 0.001 * 100 * 100 / 2.0, 0.2);  // a heading with a constant rate
}

// Over distances far beyond its correlation distance an error keeps its standard deviation.
TEST(ParticleSet, PersistentErrorsKeepTheirStandardDeviation) {
  ParticleOptions options = noise_free_options();
  options.min_count = options.max_count = 5000;
  options.scale_sigma = 0.01;
  options.scale_correlation_distance = 20;
  ParticleSet set(options, 9);
  set.scatter({0, 0, 0}, Eigen::Matrix3d::Zero());
  for (int i = 0; i < 200; ++i) set.predict({1, 0, 0}, Eigen::Matrix3d::Zero(), 1);
  double squares = 0;
  for (const Particle& particle : set.all()) squares += std::pow(particle.scale - 1, 2);
  EXPECT_NEAR(std::sqrt(squares / 5000), 0.01, 0.0005);
}

TEST(ParticleSet, ResamplesInProportionToWeight) {
  ParticleOptions options = noise_free_options();
  options.min_count = options.max_count = 100;
  ParticleSet set(options, 4);
  set.scatter({0, 0, 0}, Eigen::Matrix3d::Identity());
  auto all = set.all();
  for (size_t i = 0; i < all.size(); ++i) {
    all[i].pose.x = static_cast<double>(i);
    // 0.55, 0.25 and 0.2 of the weight on three, none on the others.
    all[i].log_weight = i == 7 ? std::log(0.55) : i == 30 ? std::log(0.25) : -1e3;
    if (i == 99) all[i].log_weight = std::log(0.2);
  }
  EXPECT_NEAR(set.effective_count(), 1 / (0.55 * 0.55 + 0.25 * 0.25 + 0.2 * 0.2), 1e-9);
  ASSERT_TRUE(set.resample_if_needed());
  std::map<double, int> copies;
  for (const Particle& particle : set.all()) ++copies[particle.pose.x];
  EXPECT_NEAR(copies[7], 55, 1);  // systematic: at most one off
  EXPECT_NEAR(copies[30], 25, 1);
  EXPECT_NEAR(copies[99], 20, 1);
  EXPECT_EQ(copies.size(), 3U);
  EXPECT_NEAR(set.entropy(), 1, 1e-12);
  EXPECT_FALSE(set.resample_if_needed());  // equal weights are not resampled
}

TEST(ParticleSet, TheNumberFollowsTheSpread) {
  ParticleOptions options = noise_free_options();
  options.min_count = 50;
  options.max_count = 5000;
  ParticleSet set(options, 5);
  set.scatter({0, 0, 0}, Eigen::Matrix3d::Zero());
  EXPECT_EQ(set.all().size(), 50U);
  set.scatter({0, 0, 0}, Eigen::Vector3d(0.25, 0.25, 0.001).asDiagonal());
  const size_t narrow = set.all().size();
  set.scatter({0, 0, 0}, Eigen::Vector3d(9, 9, 0.01).asDiagonal());
  EXPECT_GT(narrow, 50U);
  EXPECT_GT(set.all().size(), narrow);
  EXPECT_LE(set.all().size(), 5000U);
}

TEST(ParticleSet, ASecondModeIsWeightedAgainstTheFirst) {
  ParticleOptions options = noise_free_options();
  options.min_count = options.max_count = 300;
  ParticleSet set(options, 7);
  set.scatter({0, 0, 0}, Eigen::Matrix3d::Zero());
  EXPECT_EQ(set.second_mode_weight(), 0);
  EXPECT_FALSE(set.second_moments());
  set.add_mode({10, 0, 0}, Eigen::Matrix3d::Zero());
  EXPECT_NEAR(set.second_mode_weight(), 1.0 / 3, 1e-9);
  EXPECT_NEAR(set.second_moments()->mean.x, 10, 1e-9);
  EXPECT_NEAR(set.moments().mean.x, 0, 1e-9);  // not between the two
  for (Particle& particle : set.all()) particle.log_weight += particle.pose.x > 5 ? 1.5 : 0;
  EXPECT_NEAR(set.moments().mean.x, 10, 1e-9);
  EXPECT_NEAR(set.second_mode_weight(), 2 / (2 + std::exp(1.5)), 1e-9);
  for (Particle& particle : set.all()) particle.log_weight += particle.pose.x > 5 ? 6 : 0;
  EXPECT_TRUE(set.resample_if_needed() || set.second_mode_weight() == 0);
  EXPECT_EQ(set.second_mode_weight(), 0);
}

TEST(ParticleSet, AThirdPlaceReplacesTheLessLikelyMode) {
  ParticleOptions options = noise_free_options();
  options.min_count = options.max_count = 300;
  for (const bool first_is_likelier : {true, false}) {
    ParticleSet set(options, 7);
    set.scatter({0, 0, 0}, Eigen::Matrix3d::Zero());
    set.add_mode({10, 0, 0}, Eigen::Matrix3d::Zero());
    for (Particle& particle : set.all()) {
      if (first_is_likelier == (particle.pose.x < 5)) particle.log_weight += 3;
    }
    set.add_mode({0, 20, 0}, Eigen::Matrix3d::Zero());
    double weights[3] = {};  // at 0, 10 and the third
    for (const Particle& particle : set.all()) {
      weights[particle.pose.y > 5   ? 2
              : particle.pose.x > 5 ? 1
                                    : 0] += std::exp(particle.log_weight);
    }
    const size_t kept = first_is_likelier ? 0 : 1;
    EXPECT_EQ(weights[1 - kept], 0);
    EXPECT_GT(weights[kept], 0);
    EXPECT_GT(weights[2], 0);
    EXPECT_GT(set.second_mode_weight(), 0);
  }
}

TEST(ParticleSet, TwoModesThatMeetAreMerged) {
  ParticleOptions options = noise_free_options();
  options.min_count = options.max_count = 300;
  const auto doubt_at = [&](double x) {
    ParticleSet set(options, 7);
    set.scatter({0, 0, 0}, Eigen::Vector3d(0.04, 0.04, 0).asDiagonal());
    set.add_mode({x, 0, 0}, Eigen::Vector3d(0.04, 0.04, 0).asDiagonal());
    set.resample_if_needed();
    return set.second_mode_weight();
  };
  EXPECT_EQ(doubt_at(0.1), 0);  // the standard deviation of the difference is 0.28 m
  EXPECT_NEAR(doubt_at(0.6), 1.0 / 3, 1e-9);
}

// x and scale, and yaw and yaw rate, are correlated; a tenth of the particles carries the weight.
TEST(ParticleSet, KernelSmoothingKeepsMeanAndCovariance) {
  ParticleOptions options = noise_free_options();
  options.min_count = options.max_count = 20000;
  options.kernel_width = 0.5;
  ParticleSet set(options, 8);
  set.scatter({5, -3, 3.1}, Eigen::Vector3d(4, 1, 0.01).asDiagonal());
  int i = 0;
  for (Particle& particle : set.all()) {
    particle.scale = 1 + 0.01 * (particle.pose.x - 5) + 0.002 * (i % 7 - 3);
    particle.yaw_rate_bias = 0.1 * wrap_angle(particle.pose.yaw - 3.1);
    particle.log_weight = i++ % 10 == 0 ? 0 : -1e3;
  }
  ASSERT_TRUE(set.resample_if_needed());
  const PoseMoments moments = set.moments();
  EXPECT_NEAR(moments.mean.x, 5, 0.15);
  EXPECT_NEAR(moments.mean.y, -3, 0.08);
  EXPECT_NEAR(wrap_angle(moments.mean.yaw - 3.1), 0, 0.008);
  EXPECT_NEAR(moments.covariance(0, 0), 4, 0.4);
  EXPECT_NEAR(moments.covariance(2, 2), 0.01, 0.001);
  double scale = 0, rate = 0;
  std::map<double, int> copies;
  for (const Particle& particle : set.all()) {
    scale += (particle.scale - 1) * (particle.pose.x - 5) / 20000;
    rate += particle.yaw_rate_bias * wrap_angle(particle.pose.yaw - 3.1) / 20000;
    ++copies[particle.pose.x];
  }
  EXPECT_NEAR(scale, 0.04, 0.004);
  EXPECT_NEAR(rate, 0.001, 0.0001);
  EXPECT_EQ(copies.size(), 20000U);
}

// Initial weights 2/3 and 1/3; scores differ by ±1 within each mode, and by 3 between the two.
TEST(ParticleSet, WeightsBetweenAndWithinModesHaveSeparateGains) {
  ParticleOptions options = noise_free_options();
  options.min_count = options.max_count = 300;
  const auto doubt_after = [&](double within, double between) {
    ParticleSet set(options, 7);
    set.scatter({0, 0, 0}, Eigen::Matrix3d::Zero());
    set.add_mode({10, 0, 0}, Eigen::Matrix3d::Zero());
    std::vector<double> scores;
    int seen[2] = {0, 0};
    for (const Particle& particle : set.all()) {
      scores.push_back((particle.in_second_mode ? 3 : 0) +
                       (seen[particle.in_second_mode]++ % 2 ? 1 : -1));
    }
    set.update_weights(scores, within, between, 5);
    return set.second_mode_weight();
  };
  EXPECT_NEAR(doubt_after(0, 0), 1.0 / 3, 1e-9);
  EXPECT_NEAR(doubt_after(2, 0), 1.0 / 3, 1e-9);  // both modes gain the same within themselves
  EXPECT_NEAR(doubt_after(0, 0.1), 1 / (1 + 2 * std::exp(-0.3)), 1e-9);
  EXPECT_NEAR(doubt_after(2, 0.1), 1 / (1 + 2 * std::exp(-0.3)), 1e-9);

  // With one mode, particles are weighted by their scores regardless of the mean.
  ParticleSet set(options, 7);
  set.scatter({0, 0, 0}, Eigen::Matrix3d::Zero());
  std::vector<double> scores(set.all().size(), 5);
  scores[0] = 7;
  set.update_weights(scores, 0.5, 0.1, 5);
  EXPECT_NEAR(set.all()[0].log_weight - set.all()[1].log_weight, 1, 1e-9);
}

TEST(PlanarPose, ComposeAndMotionToAreInverse) {
  const PlanarPose a{3, -2, 2.9}, motion{4, 1, 1.2};
  const PlanarPose b = a.compose(motion), back = a.motion_to(b);
  EXPECT_NEAR(back.x, 4, 1e-12);
  EXPECT_NEAR(back.y, 1, 1e-12);
  EXPECT_NEAR(back.yaw, 1.2, 1e-12);
  EXPECT_LE(std::abs(b.yaw), M_PI);
}

TEST(ScoreSignificance, CountsNullScoresOfTheWindow) {
  ScoreSignificance test(2);
  EXPECT_DOUBLE_EQ(test.p_value(), 1);
  const double null[] = {1, 2, 3, 4};
  test.add(2.5, null);  // two reach it
  EXPECT_DOUBLE_EQ(test.p_value(), 3.0 / 5);
  EXPECT_NEAR(test.mean_z_score(), 0, 1e-12);
  EXPECT_FALSE(test.window_full());
  test.add(10, null);
  EXPECT_TRUE(test.window_full());
  EXPECT_DOUBLE_EQ(test.p_value(), 3.0 / 9);
  EXPECT_NEAR(test.mean_z_score(), 7.5 / std::sqrt(1.25) / 2, 1e-9);
  test.add(10, null);  // the first is out of the window
  EXPECT_DOUBLE_EQ(test.p_value(), 1.0 / 9);
  test.clear();
  EXPECT_DOUBLE_EQ(test.p_value(), 1);
}

}  // namespace
}  // namespace infuse::streetmap
