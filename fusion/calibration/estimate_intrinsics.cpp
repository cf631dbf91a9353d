#include "fusion/calibration/estimate_intrinsics.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fusion/calibration/ascent.hpp"
#include "fusion/calibration/distributions.hpp"
#include "fusion/calibration/maximize.hpp"
#include "fusion/geometry/symmetric_eigen.hpp"

namespace infuse::calibration {
namespace {

using geometry::Vector6;
using Vector10 = Parameters<10>;

struct IntrinsicsLevel {
  double sigma;   // px
  size_t points;  // maximum number

  // Wrong intrinsics shift images by pixels, however wide they are.
  ImageBlur blur() const { return ImageBlur::in_pixels(sigma); }
};
constexpr IntrinsicsLevel kLevels[] = {{8, 15'000}, {4, 30'000}, {2, 60'000}, {1, 240'000}};
constexpr IntrinsicsLevel kFinest = kLevels[std::size(kLevels) - 1];
constexpr AscentOptions kAscent{.max_iterations = 50, .tolerance = 1e-2};
// Steps that have effects of like size with those of `maximize.hpp`.
constexpr double kFocalScale = 0.02;            // of the logarithm of the focal lengths
constexpr double kPrincipalPointScale = 0.015;  // focal lengths, of the principal point
constexpr double kRadialScale = 0.03;           // of k1
constexpr double kPriorShare = 0.02;            // share of the measure that is subtracted …
constexpr double kPriorSteps = 5;  // … at so many of these steps from the given value

constexpr size_t kMinPointsPerScene = 100;  // number of points in view
constexpr double kChiSquare = 13.28;        // 99 % of 4 degrees of freedom
constexpr double kMinGainT = 4;             // Student's t of the scenes' gains (decision 3)
// Errors that imperfections of real scenes imitate: logarithm of the focal lengths, px, px, k1.
const Eigen::Vector4d kModelErrors(0.005, 1.5, 1.5, 0.005);
// A camera that was never calibrated: logarithm of the focal lengths, share of it (twice), k1.
const Eigen::Vector4d kUncalibrated(0.02, 0.02, 0.02, 0.1);
constexpr double kUncalibratedShare = 0.005;  // probability, of each of the intrinsics (decision 3)

/// Pose and a camera's intrinsics as ten scaled parameters, 0 at the initial values.
class IntrinsicsProblem {
 public:
  IntrinsicsProblem(std::span<const RigCamera> cameras, size_t camera, const Eigen::Isometry3d& T)
      : given_(cameras.begin(), cameras.end()), camera_(camera), T_(T) {
    const CameraIntrinsics& model = cameras[camera].model.intrinsics();
    scale_ << Eigen::Vector3d::Constant(kRotationScale),
        Eigen::Vector3d::Constant(kTranslationScale), kFocalScale, kPrincipalPointScale * model.fx,
        kPrincipalPointScale * model.fy, kRadialScale;
  }

  const Vector10& scale() const { return scale_; }

  Eigen::Isometry3d pose(const Vector10& d) const { return geometry::exp(xi(d)) * T_; }

  Eigen::Vector4d correction(const Vector10& d) const { return scale_.cwiseProduct(d).tail<4>(); }

  std::vector<RigCamera> cameras(const Vector10& d) const {
    const Eigen::Vector4d by = correction(d);
    CameraIntrinsics model = given_[camera_].model.intrinsics();
    model.fx *= std::exp(by(0));
    model.fy *= std::exp(by(0));
    model.cx += by(1);
    model.cy += by(2);
    model.distortion[0] += by(3);
    std::vector<RigCamera> out = given_;
    out[camera_].model = geometry::CameraModel(model);
    return out;
  }

  /// Sum of the scenes' gradients, of this camera and of others, by these parameters.
  Vector10 gradient(const Vector10& d, std::span<const SceneGradient> scene_gradients,
                    std::span<const Scene> scenes) const {
    Vector10 sum = Vector10::Zero();
    for (size_t s = 0; s < scene_gradients.size(); ++s) {
      sum.head<6>() += scene_gradients[s].head<6>();
      if (scenes[s].camera == camera_) sum.tail<4>() += scene_gradients[s].tail<4>();
    }
    sum.head<6>() = (geometry::left_jacobian(xi(d)).transpose() * sum.head<6>()).eval();
    return sum.cwiseProduct(scale_);
  }

 private:
  Vector6 xi(const Vector10& d) const { return scale_.cwiseProduct(d).head<6>(); }

  std::vector<RigCamera> given_;
  size_t camera_;
  Eigen::Isometry3d T_;
  Vector10 scale_;
};

/// Preconditioner √λ_max H^(−1/2) of the ascent, H the curvature in scaled parameters: equalises it
/// in all directions. Without it, the narrow ridge of principal point and rotation would stop an
/// ascent early.
SceneInformation preconditioner(Objective& objective, const Eigen::Isometry3d& T,
                                const Vector10& scale, double prior_weight) {
  SceneInformation curvature = total_information(objective.information(T).scenes);
  // The mean of the points' scores has the curvature of their information divided by their number.
  curvature /= static_cast<double>(objective.point_count());
  curvature = (scale.asDiagonal() * curvature * scale.asDiagonal()).eval();
  curvature.diagonal().tail<4>().array() += prior_weight;
  const auto eigen = geometry::symmetric_eigen<10>(curvature);
  return std::sqrt(eigen.values[9]) * eigen.vectors *
         eigen.values.cwiseSqrt().cwiseInverse().asDiagonal() * eigen.vectors.transpose();
}

/// Curvature of the objective by pose and intrinsics: Fisher's information, whose differences from
/// the true one are smaller than the noise of numeric derivatives, on the scale of the latter.
SceneInformation joint_curvature(Objective& objective, const Eigen::Isometry3d& T) {
  const SceneInformation information = total_information(objective.information(T).scenes);
  const geometry::Matrix6 of_pose = information.topLeftCorner<6, 6>();
  const geometry::Matrix6 H = pose_curvature(
      objective, T, kCurvatureStep * curvature_steps(of_pose, objective.median_range()));
  return (of_pose.inverse() * H).trace() / 6 * information;
}

/// c H⁻¹ J H⁻¹ of `estimate_uncertainty`, of ten parameters.
SceneInformation joint_covariance(const SceneInformation& curvature,
                                  std::vector<SceneGradient> gradients,
                                  const Uncertainty& uncertainty) {
  const double effective = uncertainty.effective_scenes;
  std::erase_if(gradients, [](const SceneGradient& one) { return one.isZero(0); });
  const auto n = static_cast<double>(gradients.size());
  SceneGradient mean = SceneGradient::Zero();
  for (const SceneGradient& one : gradients) mean += one / n;
  SceneInformation scatter = SceneInformation::Zero();
  for (const SceneGradient& one : gradients) scatter += (one - mean) * (one - mean).transpose();
  scatter *= scatter_factor(uncertainty.design_effect, gradients.size());
  const SceneInformation inverse = curvature.inverse();
  const double scale = (inverse * scatter).trace() / 10;
  const double shrinkage = kShrinkageScenes / (kShrinkageScenes + effective - 1);
  const SceneInformation J = (1 - shrinkage) * scatter + shrinkage * scale * curvature;
  return widening_of_few(2 * (effective - 1)) * inverse * J * inverse;
}

/// Gain of each of the camera's scenes, on the points in view with the given intrinsics.
std::vector<double> scene_gains(const VisiblePoints& points, const BlurredImages& images,
                                std::span<const Scene> scenes, std::span<const RigCamera> given,
                                const Eigen::Isometry3d& T_given, std::span<const RigCamera> found,
                                const Eigen::Isometry3d& T_found, size_t camera,
                                std::span<const TermOptions> terms) {
  std::vector<double> all;
  for (const VisiblePoints::Block& block : points.blocks) {
    if (block.end - block.begin < kMinPointsPerScene || scenes[block.scene].camera != camera)
      continue;
    const VisiblePoints own = select_blocks(points, std::span(&block, 1));
    Objective measure(own, images, given, scenes, terms);
    const double before = measure.evaluate(T_given, false).estimate.value;
    measure.set_cameras(found);
    all.push_back(measure.evaluate(T_found, false).estimate.value - before);
  }
  return all;
}

/// Maximum of one level, and the weight of the prior there.
struct LevelMaximum {
  Vector10 d = Vector10::Zero();
  double value = 0;  // with the prior
  double prior_weight = 0;
  bool converged = false;
};

/// Ascends from `from` with these points.
LevelMaximum ascend_level(const IntrinsicsProblem& problem, const Vector10& from,
                          const VisiblePoints& points, const BlurredImages& images,
                          std::span<const Scene> scenes, std::span<const TermOptions> terms) {
  std::vector<RigCamera> trial_cameras = problem.cameras(from);
  Objective objective(points, images, trial_cameras, scenes, terms);
  const double all = std::max(0.0, objective.evaluate(problem.pose(from), false).estimate.value);
  const double weight = 2 * kPriorShare * all / (kPriorSteps * kPriorSteps);
  const SceneInformation steps =
      preconditioner(objective, problem.pose(from), problem.scale(), weight);
  const auto value = [&](const Vector10& y, Vector10* gradient) {
    const Vector10 d = from + steps * y;
    Vector10 prior_gradient = weight * d;
    prior_gradient.head<6>().setZero();
    trial_cameras = problem.cameras(d);
    objective.set_cameras(trial_cameras);
    dependence::Estimate estimate;
    const std::vector<SceneGradient> scene_gradients =
        objective.scene_gradients(problem.pose(d), &estimate);
    *gradient = steps * (problem.gradient(d, scene_gradients, scenes) - prior_gradient);
    return estimate.value - 0.5 * prior_gradient.dot(d);
  };
  const AscentResult<10> ascent = ascend_bfgs_10d(value, kAscent);
  return {.d = from + steps * ascent.d,
          .value = ascent.value,
          .prior_weight = weight,
          .converged = ascent.converged};
}

/// Mean of the values divided by its standard error (Student's t); 0 where they are all alike.
double students_t(std::span<const double> values) {
  const auto n = static_cast<double>(values.size());
  double sum = 0, squares = 0;
  for (const double one : values) sum += one;
  for (const double one : values) squares += (one - sum / n) * (one - sum / n);
  return squares > 0 ? sum / std::sqrt(n / (n - 1) * squares) : 0;
}

/// C + K: covariance of the estimate with that of what is known and of model errors.
Eigen::Matrix4d tested_covariance(const IntrinsicsEstimate& estimate,
                                  const KnownParameters& known) {
  const Eigen::Vector4d assumed(known.focal_sigma, known.principal_point_sigma,
                                known.principal_point_sigma, known.radial_sigma);
  Eigen::Matrix4d sum = estimate.covariance;
  sum.diagonal() += assumed.cwiseAbs2() + kModelErrors.cwiseAbs2();
  return sum;
}

/// Arguments of `estimate_intrinsics` that its steps share.
struct EstimateInput {
  std::span<const Scene> scenes;
  size_t camera;
  std::span<const TermOptions> search_terms, terms;
  ImagePyramid& images;
  const VisibilityOptions& visibility;

  VisiblePoints visible_points(std::span<const RigCamera> cameras, const Eigen::Isometry3d& T,
                               size_t max_points) const {
    VisibilityOptions thinned = visibility;
    thinned.max_points = max_points;
    return select_visible(scenes, cameras, T, thinned);
  }
};

/// Ascends all levels but the finest; returns nothing if `stop` was requested.
std::optional<Vector10> ascend_coarse_levels(const EstimateInput& input,
                                             const IntrinsicsProblem& problem,
                                             const std::stop_token& stop) {
  Vector10 d = Vector10::Zero();
  for (const IntrinsicsLevel& level : std::span(kLevels).first(std::size(kLevels) - 1)) {
    const VisiblePoints points =
        input.visible_points(problem.cameras(d), problem.pose(d), level.points);
    const BlurredImages& images = input.images.at(level.blur());
    d = ascend_level(problem, d, points, images, input.scenes, input.search_terms).d;
    if (stop.stop_requested()) return std::nullopt;
  }
  return d;
}

/// Maximum of the finest level. The measure has many of like height: the one near the given
/// intrinsics counts, unless the scenes agree that the one near `coarse`, to which the coarse
/// levels led, is higher.
LevelMaximum find_maximum(const EstimateInput& input, const IntrinsicsProblem& problem,
                          const Vector10& coarse, const VisiblePoints& given_points) {
  const BlurredImages& images = input.images.at(kFinest.blur());
  const auto ascend = [&](const Vector10& from) {
    return ascend_level(problem, from, given_points, images, input.scenes, input.terms);
  };
  LevelMaximum best = ascend(Vector10::Zero());
  if (const LevelMaximum other = ascend(coarse); other.value > best.value) {
    const std::vector<double> gains = scene_gains(
        given_points, images, input.scenes, problem.cameras(best.d), problem.pose(best.d),
        problem.cameras(other.d), problem.pose(other.d), input.camera, input.terms);
    if (!best.converged || students_t(gains) > kMinGainT) best = other;
  }
  return best;
}

/// Sets the covariance, and takes the prior out of the correction.
void add_uncertainty(const EstimateInput& input, const IntrinsicsProblem& problem,
                     const LevelMaximum& maximum, const Uncertainty& uncertainty,
                     IntrinsicsEstimate& estimate) {
  const std::vector<RigCamera> corrected = problem.cameras(maximum.d);
  const VisiblePoints points =
      input.visible_points(corrected, estimate.T_refcam_lidar, kFinest.points);
  Objective objective(points, input.images.at(kFinest.blur()), corrected, input.scenes,
                      input.terms);
  const SceneInformation curvature = joint_curvature(objective, estimate.T_refcam_lidar);
  estimate.covariance =
      joint_covariance(curvature, objective.scene_gradients(estimate.T_refcam_lidar), uncertainty)
          .bottomRightCorner<4, 4>();
  // One step of Newton's without the prior, whose gradient is the only one there.
  SceneGradient prior_gradient = SceneGradient::Zero();
  prior_gradient.tail<4>() =
      maximum.prior_weight * maximum.d.tail<4>().cwiseQuotient(problem.scale().tail<4>());
  estimate.correction += curvature.ldlt().solve(prior_gradient).tail<4>();
}

/// Variances of the intrinsics of a camera that was never calibrated; `focal_length` in px.
Eigen::Vector4d uncalibrated_variances(double focal_length) {
  Eigen::Vector4d sigma = kUncalibrated;
  sigma.segment<2>(1) *= focal_length;
  return sigma.cwiseAbs2();
}

}  // namespace

std::optional<IntrinsicsEstimate> estimate_intrinsics(
    std::span<const Scene> scenes, std::span<const RigCamera> cameras, size_t camera,
    std::span<const TermOptions> search_terms, std::span<const TermOptions> terms,
    ImagePyramid& images, const VisibilityOptions& visibility,
    const Eigen::Isometry3d& T_refcam_lidar, const Uncertainty& uncertainty,
    const std::stop_token& stop) {
  if (std::count_if(scenes.begin(), scenes.end(), [&](const Scene& scene) {
        return scene.camera == camera;
      }) < kMinScenesOfIntrinsics) {
    return std::nullopt;
  }
  const EstimateInput input{.scenes = scenes,
                            .camera = camera,
                            .search_terms = search_terms,
                            .terms = terms,
                            .images = images,
                            .visibility = visibility};
  const IntrinsicsProblem problem(cameras, camera, T_refcam_lidar);
  const std::optional<Vector10> coarse = ascend_coarse_levels(input, problem, stop);
  if (!coarse) return std::nullopt;
  VisiblePoints given_points = input.visible_points(cameras, T_refcam_lidar, kFinest.points);
  const LevelMaximum maximum = find_maximum(input, problem, *coarse, given_points);
  if (stop.stop_requested()) return std::nullopt;
  const bool within_bounds = maximum.d.tail<4>().cwiseAbs().maxCoeff() <= kPriorSteps;
  IntrinsicsEstimate out{.T_refcam_lidar = problem.pose(maximum.d),
                         .correction = problem.correction(maximum.d),
                         .converged = maximum.converged && within_bounds};
  const std::vector<double> gains =
      scene_gains(given_points, images.at(kFinest.blur()), scenes, cameras, T_refcam_lidar,
                  problem.cameras(maximum.d), out.T_refcam_lidar, camera, terms);
  out.scenes = static_cast<int>(gains.size());
  if (out.scenes < kMinScenesOfIntrinsics) return std::nullopt;
  given_points = {};  // released before others are chosen
  add_uncertainty(input, problem, maximum, uncertainty, out);
  for (const double gain : gains) out.improved_scenes += gain > 0 ? 1 : 0;
  out.significance = students_t(gains);
  return out;
}

std::vector<ImageBlur> intrinsics_blurs() {
  std::vector<ImageBlur> blurs;
  for (const IntrinsicsLevel& level : kLevels) blurs.push_back(level.blur());
  return blurs;
}

std::optional<ParameterCheck> detect_gross_error(const IntrinsicsEstimate& estimate,
                                                 std::span<const RigCamera> cameras, size_t camera,
                                                 const KnownParameters& known) {
  const Eigen::Matrix4d spread = tested_covariance(estimate, known);
  const bool contradicts =
      estimate.correction.dot(spread.ldlt().solve(estimate.correction)) > kChiSquare;
  if (!contradicts || !(estimate.significance > 0)) {
    if (estimate.converged) return std::nullopt;
    ParameterCheck unknown = make_intrinsic_check(0, 0, camera, cameras.size());
    unknown.parameter.replace(0, std::string("focal length").size(), "set of intrinsics");
    unknown.significant = unknown.serious = unknown.gross = true;
    return unknown;
  }
  Eigen::Index which = 0;
  const double farthest =
      estimate.correction.cwiseQuotient(spread.diagonal().cwiseSqrt()).cwiseAbs().maxCoeff(&which);
  ParameterCheck check = make_intrinsic_check(static_cast<size_t>(which),
                                              estimate.correction(which), camera, cameras.size());
  check.significance = std::copysign(farthest, estimate.correction(which));
  check.significant = check.serious = check.gross = true;
  return check;
}

Eigen::Vector4d detection_limits(const IntrinsicsEstimate& estimate, const KnownParameters& known) {
  const Eigen::Matrix4d information =
      tested_covariance(estimate, known).ldlt().solve(Eigen::Matrix4d::Identity());
  return (kChiSquare * information.diagonal().cwiseInverse()).cwiseSqrt();
}

Eigen::Vector4d unseen_errors(const IntrinsicsEstimate& estimate, double focal_length,
                              const KnownParameters& known) {
  const Eigen::Vector4d W = uncalibrated_variances(focal_length);
  const Eigen::Vector4d S = tested_covariance(estimate, known).diagonal();
  Eigen::Vector4d unseen;
  for (Eigen::Index i = 0; i < 4; ++i) {
    const double of_estimate = W(i) + S(i);
    const double shown = std::sqrt(kChiSquare * S(i) / of_estimate);  // standard deviations
    const double hidden = std::erf(shown / std::numbers::sqrt2);
    const double density = std::exp(-0.5 * shown * shown) / std::sqrt(2 * std::numbers::pi);
    const double estimated = of_estimate * (hidden - 2 * shown * density);  // of x², where hidden
    const double share = W(i) / of_estimate;
    unseen(i) = kUncalibratedShare * (share * share * estimated + share * S(i) * hidden);
  }
  return unseen.cwiseSqrt();
}

Eigen::Vector4d unmeasured_errors(const std::optional<IntrinsicsEstimate>& estimate,
                                  double focal_length, const KnownParameters& known) {
  const Eigen::Vector4d W = uncalibrated_variances(focal_length);
  if (!estimate || !estimate->converged) return W.cwiseSqrt();
  const Eigen::Vector4d S = tested_covariance(*estimate, known).diagonal();
  const Eigen::Vector4d share = W.cwiseQuotient(W + S);
  return (share.cwiseProduct(estimate->correction).cwiseAbs2() + share.cwiseProduct(S)).cwiseSqrt();
}

}  // namespace infuse::calibration
