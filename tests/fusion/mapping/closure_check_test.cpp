#include "fusion/mapping/closure_check.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/fusion/registration/random_room.hpp"

namespace infuse::mapping {
namespace {

Eigen::Isometry3d place(double x, double y, double heading) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() = Eigen::Vector3d(x, y, 0);
  return T;
}

Submap submap_of(const registration::PointCloud& cloud) {
  Submap submap;
  submap.resize(cloud.size());
  submap.x = cloud.x;
  submap.y = cloud.y;
  submap.z = cloud.z;
  return submap;
}

Submap room_from(unsigned seed, const Eigen::Isometry3d& T_room_sensor) {
  return submap_of(registration::random_room(seed, 30'000, 0.01, T_room_sensor));
}

TEST(ClosureCheck, FindsThePoseFromAGuessHalfAMetreOff) {
  const Eigen::Isometry3d a = place(-3, 1, 0.3), b = place(1, -2, 1.2);
  const Eigen::Isometry3d truth = a.inverse() * b;
  const PreparedSubmap target(room_from(1, a), {}), source(room_from(2, b), {});
  const ClosureCheck check = check_closure(target, source, truth * place(0.4, -0.3, 0.05));
  ASSERT_TRUE(check.usable()) << check.reason;
  const Eigen::Isometry3d error = truth.inverse() * check.registration.T_target_source;
  EXPECT_LT(error.translation().norm(), 0.03);
  EXPECT_LT(Eigen::AngleAxisd(error.linear()).angle(), 0.005);
  // The stated uncertainty of the position is the noise of the options and a little more.
  Eigen::Matrix<double, 3, 6> G;
  G << -geometry::skew(truth.translation()), Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d C = G * check.registration.covariance * G.transpose();
  EXPECT_GE(std::sqrt(C(0, 0)), 0.99 * ClosureCheckOptions().translation_noise);
  EXPECT_LT(std::sqrt(C(0, 0)), 1.3 * ClosureCheckOptions().translation_noise);
}

// All walls fit, but one place has screens across the room, through which the other one saw.
TEST(ClosureCheck, RefusesAPoseThatBeamsContradict) {
  const Eigen::Isometry3d a = place(-3, 1, 0.3), b = place(-2, -2, 1.2);
  registration::PointCloud screened = registration::random_room(2, 30'000, 0.01, b);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  for (size_t i = 0; i < screened.size(); i += 3) {
    const double along = unit(random), up = -2 + 8 * unit(random);
    const Eigen::Vector3d wall = i % 2 == 0 ? Eigen::Vector3d(0.5, -10 + 20 * along, up)
                                            : Eigen::Vector3d(-15 + 30 * along, -0.5, up);
    const Eigen::Vector3f p = (b.inverse() * wall).cast<float>();
    screened.x[i] = p.x();
    screened.y[i] = p.y();
    screened.z[i] = p.z();
  }
  const PreparedSubmap target(room_from(1, a), {}), source(submap_of(screened), {});
  const ClosureCheck check = check_closure(target, source, a.inverse() * b);
  EXPECT_FALSE(check.usable());
  EXPECT_EQ(check.reason, "the beams of one place pass through what the other shows");
}

TEST(ClosureCheck, RefusesWhatTheGeometryLeavesFree) {
  registration::PointCloud street;  // ground and two endless walls
  street.resize(20'000);
  std::mt19937 random(3);
  std::uniform_real_distribution<float> along(-40, 40), across(-6, 6), height(-2, 5);
  for (size_t i = 0; i < street.size(); ++i) {
    const bool ground = i % 2 == 0;
    street.x[i] = along(random);
    street.y[i] = ground ? across(random) : (i % 4 == 1 ? 6.F : -6.F);
    street.z[i] = ground ? -2.F : height(random);
  }
  const PreparedSubmap a(submap_of(street), {}), b(submap_of(street), {});
  const ClosureCheck check = check_closure(a, b, place(0.3, 0.1, 0));
  EXPECT_FALSE(check.usable());
  EXPECT_NE(check.reason.find("the geometry leaves free: translation along x"), std::string::npos)
      << check.reason;
}

TEST(ClosureCheck, RefusesPlacesWithoutPoints) {
  const PreparedSubmap room(room_from(1, place(0, 0, 0)), {}), nothing(Submap{}, {});
  EXPECT_FALSE(check_closure(room, nothing, Eigen::Isometry3d::Identity()).usable());
  EXPECT_FALSE(check_closure(nothing, room, std::nullopt).usable());
}

}  // namespace
}  // namespace infuse::mapping
