#include "fusion/registration/factors.hpp"

#include <gtest/gtest.h>

#include <random>

#include "fusion/registration/gicp.hpp"
#include "tests/fusion/registration/random_room.hpp"

namespace infuse::registration {
namespace {

/// A user's factor: distance between the points, by a Cauchy kernel of 5 cm.
struct PointToPointFactor {
  static constexpr int kDirections = 3;
  static constexpr double kIsotropic = 0;
  PairNoise noise{.plane_variance = 0.5};

  template <class Number>
  [[gnu::always_inline]] VectorOf<Number> residual(const Pair<Number>& pair) const {
    return pair.q - pair.p;
  }

  template <class Number>
  [[gnu::always_inline]] Information<Number, kDirections> information(const Pair<Number>&) const {
    const Number o{}, i = o + 1;
    return {{{i, o, o}, {o, i, o}, {o, o, i}}, {{i, o, o}, {o, i, o}, {o, o, i}}, i};
  }

  template <class Number>
  [[gnu::always_inline]] Number weight(const Number& square) const {
    return 1 / (1 + square * ScalarOf<Number>(400));
  }
};

Eigen::Isometry3d motion() {
  geometry::Vector6 twist;
  twist << 0.004, -0.002, 0.006, 0.06, -0.05, 0.03;
  return geometry::exp(twist);
}

/// The same points of a room from two poses.
template <class Factor>
RegistrationResult register_copies() {
  const PointCloud room = random_room(1, 8000, 0, Eigen::Isometry3d::Identity());
  const PreparedCloud target = prepare_cloud(room.points(), {.voxel_size = 0});
  PointCloud moved = target.cloud;
  const Eigen::Isometry3f T = motion().inverse().cast<float>();
  for (size_t i = 0; i < moved.size(); ++i) {
    const Eigen::Vector3f p = T * Eigen::Vector3f(moved.x[i], moved.y[i], moved.z[i]);
    const Eigen::Vector3f n = T.linear() * Eigen::Vector3f(moved.nx[i], moved.ny[i], moved.nz[i]);
    moved.x[i] = p.x(), moved.y[i] = p.y(), moved.z[i] = p.z();
    moved.nx[i] = n.x(), moved.ny[i] = n.y(), moved.nz[i] = n.z();
  }
  RegistrationOptions options;
  options.steps.rotation_tolerance = options.steps.translation_tolerance = 1e-6;
  return Registration<Factor>(options).align(target, moved, Eigen::Isometry3d::Identity());
}

template <class Factor>
class Factors : public testing::Test {};
using AllFactors =
    testing::Types<GicpFactor, MapPlaneFactor, PointToPlaneFactor, PointToPointFactor>;
TYPED_TEST_SUITE(Factors, AllFactors);

TYPED_TEST(Factors, BringCopiesTogether) {
  const RegistrationResult result = register_copies<TypeParam>();
  ASSERT_TRUE(result.converged) << result.reason;
  EXPECT_EQ(result.free_directions, 0);
  const geometry::Vector6 error = geometry::log(motion() * result.T_target_source.inverse());
  EXPECT_LT(error.head<3>().norm(), 1e-5);
  EXPECT_LT(error.tail<3>().norm(), 1e-4);
}

/// Random pairs with unit normals.
Pairs random_pairs(size_t size) {
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  Pairs pairs;
  pairs.resize(size);
  for (size_t i = 0; i < size; ++i) {
    for (Pairs::Field* field : {&pairs.px, &pairs.py, &pairs.pz}) (*field)[i] = 5 * normal(random);
    pairs.qx[i] = pairs.px[i] + 0.1F * normal(random);
    pairs.qy[i] = pairs.py[i] + 0.1F * normal(random);
    pairs.qz[i] = pairs.pz[i] + 0.1F * normal(random);
    const Eigen::Vector3f s(normal(random), normal(random), normal(random));
    const Eigen::Vector3f t(normal(random), normal(random), normal(random));
    pairs.sx[i] = s.normalized().x(), pairs.sy[i] = s.normalized().y();
    pairs.sz[i] = s.normalized().z(), pairs.tx[i] = t.normalized().x();
    pairs.ty[i] = t.normalized().y(), pairs.tz[i] = t.normalized().z();
    pairs.weight[i] = 1;
  }
  return pairs;
}

/// Σ rᵀ W r of pairs whose source has moved, in double precision from W's definition.
template <class Factor>
double cost(const Pairs& pairs, const Factor& factor, const Eigen::Isometry3d& T) {
  double sum = 0;
  for (size_t i = 0; i < pairs.size; ++i) {
    const Pair<double> pair{T * Eigen::Vector3d(pairs.px[i], pairs.py[i], pairs.pz[i]),
                            {pairs.sx[i], pairs.sy[i], pairs.sz[i]},
                            {pairs.qx[i], pairs.qy[i], pairs.qz[i]},
                            {pairs.tx[i], pairs.ty[i], pairs.tz[i]}};
    const auto W = factor.information(pair);
    Eigen::Matrix3d full = Factor::kIsotropic * Eigen::Matrix3d::Identity();
    for (int k = 0; k < Factor::kDirections; ++k) {
      for (int l = 0; l < Factor::kDirections; ++l) {
        full += W.scale * W.coefficient[k][l] * W.direction[k] * W.direction[l].transpose();
      }
    }
    const Eigen::Vector3d r = factor.residual(pair);
    sum += r.dot(full * r);
  }
  return sum;
}

template <class Factor>
class Linearise : public testing::Test {};
using PlainFactors = testing::Types<GicpFactor, MapPlaneFactor, PointToPlaneFactor>;
TYPED_TEST_SUITE(Linearise, PlainFactors);

TYPED_TEST(Linearise, IsTheDerivativeOfTheCost) {
  const Pairs pairs = random_pairs(301);
  TypeParam factor;
  factor.noise.plane_variance = 0.2;
  const PoseSystem system = linearise(pairs, factor);
  const auto at = [&](const geometry::Vector6& twist) {
    return cost(pairs, factor, geometry::exp(twist));
  };
  const double middle = at(geometry::Vector6::Zero());
  EXPECT_NEAR(system.cost / middle, 1, 1e-4);
  const geometry::Matrix6 H = system.planes + system.isotropic;
  constexpr double kStep = 1e-2;
  const double gradient_scale = system.gradient.norm(), scale = H.norm();
  for (int i = 0; i < 6; ++i) {
    const geometry::Vector6 twist = kStep * geometry::Vector6::Unit(i);
    const double plus = at(twist), minus = at(-twist);
    EXPECT_NEAR((minus - plus) / (4 * kStep), system.gradient[i], 1e-2 * gradient_scale) << i;
    EXPECT_NEAR((plus - 2 * middle + minus) / (2 * kStep * kStep), H(i, i), 2e-2 * scale) << i;
  }
}

TEST(GicpFactor, IsTheInverseOfTheSumOfTwoPlanesCovariances) {
  const Eigen::Vector3d n1 = Eigen::Vector3d(1, 2, 3).normalized();
  const Eigen::Vector3d n2 = Eigen::Vector3d(-1, 1, 2).normalized();
  const GicpFactor factor{{.plane_variance = 0.01}};
  const auto W = factor.information(Pair<double>{{0, 0, 0}, n2, {1, 0, 0}, n1});
  Eigen::Matrix3d sum = 2 * Eigen::Matrix3d::Identity();
  Eigen::Matrix3d found = 0.5 * Eigen::Matrix3d::Identity();
  for (const Eigen::Vector3d& n : {n1, n2}) sum -= 0.99 * n * n.transpose();
  for (int k = 0; k < 2; ++k) {
    for (int l = 0; l < 2; ++l) {
      found += W.scale * W.coefficient[k][l] * W.direction[k] * W.direction[l].transpose();
    }
  }
  EXPECT_LT((found * sum - Eigen::Matrix3d::Identity()).norm(), 1e-12);
}

}  // namespace
}  // namespace infuse::registration
