#include "fusion/registration/global_guess.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "fusion/registration/view_agreement.hpp"
#include "tests/fusion/registration/random_room.hpp"

namespace infuse::registration {
namespace {

Eigen::Isometry3d pose(double x, double y, double heading) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() = Eigen::Vector3d(x, y, 0);
  return T;
}

/// A room with a partition, so that it is not the same after half a turn.
PointCloud room(unsigned seed, const Eigen::Isometry3d& T_room_sensor) {
  PointCloud cloud = random_room(seed, 24'000, 0.01, T_room_sensor);
  const size_t first = cloud.size();
  cloud.resize(first + 8000);
  std::mt19937 random(seed + 100);
  std::uniform_real_distribution<double> unit(0, 1);
  for (size_t i = first; i < cloud.size(); ++i) {
    const Eigen::Vector3d wall =
        i % 2 == 0 ? Eigen::Vector3d(9, -10 + 9 * unit(random), -2 + 8 * unit(random))
                   : Eigen::Vector3d(9 + 3 * unit(random), -1, -2 + 8 * unit(random));
    const Eigen::Vector3f p = (T_room_sensor.inverse() * wall).cast<float>();
    cloud.x[i] = p.x();
    cloud.y[i] = p.y();
    cloud.z[i] = p.z();
  }
  return cloud;
}

/// A room is small: a finer grid than that of a street.
GlobalGuessOptions indoors() {
  GlobalGuessOptions options;
  options.voxel_size = 0.3;
  options.fpfh = {.normal_radius = 0.9, .feature_radius = 1.5};
  options.consensus.inlier_distance = 0.4;
  return options;
}

TEST(GlobalGuess, FindsAnyHeadingAcrossARoom) {
  const PointCloud target = room(1, pose(-7, -3, 0.2));
  for (const double heading : {0.2, std::numbers::pi, -1.4}) {
    const PointCloud source = room(2, pose(6, 2, heading));
    const Eigen::Isometry3d truth = pose(-7, -3, 0.2).inverse() * pose(6, 2, heading);
    const RegistrationResult found = find_global_guess(target.points(), source.points(), indoors());
    ASSERT_TRUE(found.usable()) << found.reason;
    const geometry::Vector6 error = geometry::log(truth * found.T_target_source.inverse());
    EXPECT_LT(error.head<3>().norm(), 0.01) << heading;
    EXPECT_LT((truth.translation() - found.T_target_source.translation()).norm(), 0.05) << heading;
  }
}

TEST(GlobalGuess, IdenticalScansAreNamed) {
  const PointCloud scan = room(1, pose(-7, -3, 0.2));
  const RegistrationResult found = find_global_guess(scan.points(), scan.points(), indoors());
  EXPECT_FALSE(found.usable());
  EXPECT_NE(std::string(found.reason).find("identical"), std::string::npos) << found.reason;
}

TEST(GlobalGuess, StatesAReasonForScansThatCannotBeAligned) {
  const PointCloud scan = room(1, pose(0, 0, 0));
  PointCloud nothing, few = scan, missing = scan, elsewhere = scan;
  few.resize(10);
  for (auto* field : {&missing.x, &missing.y, &missing.z}) {
    field->assign(field->size(), std::numeric_limits<float>::quiet_NaN());
  }
  // Another world: boxes of noise.
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(-20, 20);
  for (auto* field : {&elsewhere.x, &elsewhere.y, &elsewhere.z}) {
    for (float& value : *field) value = unit(random);
  }
  for (const PointCloud* other : {&nothing, &few, &missing, &elsewhere}) {
    for (const bool swapped : {false, true}) {
      const RegistrationResult found = find_global_guess(
          (swapped ? *other : scan).points(), (swapped ? scan : *other).points(), indoors());
      EXPECT_FALSE(found.usable());
      EXPECT_STRNE(found.reason, "");
    }
  }
}

TEST(GlobalGuess, RefusesTheTwoWaysRoundOfASymmetricRoom) {
  // An empty room is the same after half a turn.
  const auto empty_room = [](unsigned seed, const Eigen::Isometry3d& T_room_sensor) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    PointCloud cloud;
    cloud.resize(20'000);
    for (size_t i = 0; i < cloud.size(); ++i) {
      Eigen::Vector3d p(10 * unit(random), 6 * unit(random), 2 * unit(random));
      const auto axis = static_cast<Eigen::Index>(random() % 3);
      const Eigen::Vector3d half(10, 6, 2);
      p[axis] = p[axis] > 0 ? half[axis] : -half[axis];
      const Eigen::Vector3f q = (T_room_sensor.inverse() * p).cast<float>();
      cloud.x[i] = q.x();
      cloud.y[i] = q.y();
      cloud.z[i] = q.z();
    }
    return cloud;
  };
  const RegistrationResult found = find_global_guess(
      empty_room(1, pose(2, 1, 0)).points(), empty_room(2, pose(-3, 0, 0.4)).points(), indoors());
  EXPECT_FALSE(found.usable());
}

TEST(ViewAgreement, IsHighAtTheTruthAndLowWhereBeamsPassedThroughPoints) {
  const Eigen::Isometry3d there = pose(-5, 0, 0), here = pose(5, 1, 1);
  const PreparedCloud target = prepare_cloud(room(1, there).points(), {.voxel_size = 0.3});
  const PreparedCloud source = prepare_cloud(room(2, here).points(), {.voxel_size = 0.3});
  const ViewOfScan target_view(target), source_view(source);
  const auto share = [&](const Eigen::Isometry3d& T) {
    return agreement(target_view, target.cloud, source_view, source.cloud, T).share();
  };
  const Eigen::Isometry3d truth = there.inverse() * here;
  EXPECT_GT(share(truth), 0.95);
  EXPECT_LT(share(pose(-4, 0, 0) * truth), 0.85);
  EXPECT_LT(share(truth * pose(0, 0, std::numbers::pi)), 0.85);
}

TEST(GlobalGuess, StatesWhatIsWrongWithTheOptions) {
  EXPECT_FALSE(GlobalGuessOptions().invalid());
  EXPECT_TRUE(GlobalGuessOptions{.voxel_size = 0}.invalid());
  EXPECT_TRUE(GlobalGuessOptions{.max_keypoints = 1}.invalid());
  EXPECT_TRUE(GlobalGuessOptions{.min_agreement = 1}.invalid());
  EXPECT_TRUE(GlobalGuessOptions{.min_lead = -1}.invalid());
}

}  // namespace
}  // namespace infuse::registration
