#include "fusion/calibration/estimate_intrinsics.hpp"

#include <algorithm>
#include <cmath>

#include "fusion/calibration/ascent.hpp"

namespace infuse::calibration {
namespace {

using geometry::Vector6;
using Vector10 = Parameters<10>;

struct IntrinsicsLevel {
  double sigma;   // px
  size_t points;  // maximum number
};
constexpr IntrinsicsLevel kLevels[] = {{8, 15'000}, {4, 30'000}, {2, 60'000}, {1, 60'000}};
constexpr AscentOptions kAscent{.max_iterations = 50, .tolerance = 1e-2};
constexpr double kRotationScale = 0.01;         // rad; steps of these sizes
constexpr double kTranslationScale = 0.1;       // m; have effects of like size
constexpr double kFocalScale = 0.02;            // of the logarithm of the focal lengths
constexpr double kPrincipalPointScale = 0.015;  // focal lengths, of the principal point
constexpr double kRadialScale = 0.03;           // of k1
constexpr double kPriorShare = 0.02;            // share of the measure that is subtracted …
constexpr double kPriorSteps = 5;  // … at so many of these steps from the given value

constexpr int kMinScenesOfCamera = 8;       // number of scenes
constexpr size_t kMinPointsPerScene = 200;  // number of points in view
constexpr double kMinSignificance = 4;      // standard errors
constexpr double kGrossFocalError = 0.02;
constexpr double kGrossPrincipalPointError = 0.015;  // focal lengths
constexpr double kGrossRadialError = 0.04;

/// Pose and a camera's intrinsics as ten scaled parameters, 0 at the initial values. The parameters
/// of the principal point include the rotation that keeps the image's middle in place: without it
/// they would lead along a narrow ridge.
class IntrinsicsProblem {
 public:
  IntrinsicsProblem(std::span<const RigCamera> cameras, size_t camera, const Eigen::Isometry3d& T)
      : given_(cameras.begin(), cameras.end()), camera_(camera), T_(T) {
    const CameraIntrinsics& model = cameras[camera].model.intrinsics();
    scale_ << Eigen::Vector3d::Constant(kRotationScale),
        Eigen::Vector3d::Constant(kTranslationScale), kFocalScale, kPrincipalPointScale * model.fx,
        kPrincipalPointScale * model.fy, kRadialScale;
    const geometry::Matrix6 Ad_refcam_camera =
        geometry::adjoint(cameras[camera].T_camera_refcam.inverse());
    rotation_by_cx_ = Ad_refcam_camera * Vector6::Unit(1) / -model.fx;
    rotation_by_cy_ = Ad_refcam_camera * Vector6::Unit(0) / model.fy;
  }

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
  Vector10 gradient(const Vector10& d, std::span<const SceneGradient> pulls,
                    std::span<const Scene> scenes) const {
    Vector10 sum = Vector10::Zero();
    for (size_t s = 0; s < pulls.size(); ++s) {
      sum.head<6>() += pulls[s].head<6>();
      if (scenes[s].camera == camera_) sum.tail<4>() += pulls[s].tail<4>();
    }
    sum.head<6>() = (geometry::left_jacobian(xi(d)).transpose() * sum.head<6>()).eval();
    sum(7) += rotation_by_cx_.dot(sum.head<6>());
    sum(8) += rotation_by_cy_.dot(sum.head<6>());
    return sum.cwiseProduct(scale_);
  }

 private:
  Vector6 xi(const Vector10& d) const {
    const Vector10 s = scale_.cwiseProduct(d);
    return s.head<6>() + s(7) * rotation_by_cx_ + s(8) * rotation_by_cy_;
  }

  std::vector<RigCamera> given_;
  size_t camera_;
  Eigen::Isometry3d T_;
  Vector10 scale_;
  Vector6 rotation_by_cx_, rotation_by_cy_;
};

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

}  // namespace

std::optional<IntrinsicsEstimate> estimate_intrinsics(
    std::span<const Scene> scenes, std::span<const RigCamera> cameras, size_t camera,
    std::span<const TermOptions> terms, ImagePyramid& images, const VisibilityOptions& visibility,
    const Eigen::Isometry3d& T_refcam_lidar, const std::stop_token& stop) {
  if (std::count_if(scenes.begin(), scenes.end(), [&](const Scene& scene) {
        return scene.camera == camera;
      }) < kMinScenesOfCamera) {
    return std::nullopt;
  }
  const IntrinsicsProblem freed(cameras, camera, T_refcam_lidar);
  Vector10 at = Vector10::Zero();
  bool converged = false;
  VisibilityOptions thinned = visibility;
  for (const IntrinsicsLevel& level : kLevels) {
    thinned.max_points = level.points;
    std::vector<RigCamera> trial_cameras = freed.cameras(at);
    const VisiblePoints points = select_visible(scenes, trial_cameras, freed.pose(at), thinned);
    Objective objective(points, images.at(level.sigma), trial_cameras, scenes, terms);
    const double all = std::max(0.0, objective.evaluate(freed.pose(at), false).estimate.value);
    const double weight = 2 * kPriorShare * all / (kPriorSteps * kPriorSteps);
    const Vector10 from = at;
    const auto value = [&](const Vector10& step, Vector10* gradient) {
      const Vector10 d = from + step;
      Vector10 prior_gradient = weight * d;
      prior_gradient.head<6>().setZero();
      trial_cameras = freed.cameras(d);
      objective.set_cameras(trial_cameras);
      dependence::Estimate estimate;
      const std::vector<SceneGradient> pulls = objective.scene_gradients(freed.pose(d), &estimate);
      *gradient = freed.gradient(d, pulls, scenes) - prior_gradient;
      return estimate.value - 0.5 * prior_gradient.dot(d);
    };
    const AscentResult<10> ascent = ascend_bfgs_10d(value, kAscent);
    at = from + ascent.d;
    converged = ascent.converged && at.tail<4>().cwiseAbs().maxCoeff() <= kPriorSteps;
    if (stop.stop_requested()) return std::nullopt;
  }
  IntrinsicsEstimate out{
      .T_refcam_lidar = freed.pose(at), .correction = freed.correction(at), .converged = converged};
  const std::vector<double> gain =
      scene_gains(select_visible(scenes, cameras, T_refcam_lidar, thinned),
                  images.at(std::end(kLevels)[-1].sigma), scenes, cameras, T_refcam_lidar,
                  freed.cameras(at), out.T_refcam_lidar, camera, terms);
  out.scenes = static_cast<int>(gain.size());
  if (out.scenes < kMinScenesOfCamera) return std::nullopt;
  double sum = 0, squares = 0;
  for (const double one : gain) {
    sum += one;
    out.improved_scenes += one > 0 ? 1 : 0;
  }
  const double n = out.scenes;
  for (const double one : gain) squares += (one - sum / n) * (one - sum / n);
  out.significance = squares > 0 ? sum / std::sqrt(n / (n - 1) * squares) : 0;
  return out;
}

std::optional<ModelMismatch> detect_gross_mismatch(const IntrinsicsEstimate& freed,
                                                   std::span<const RigCamera> cameras,
                                                   size_t camera) {
  const CameraIntrinsics& model = cameras[camera].model.intrinsics();
  const Eigen::Vector4d gross(kGrossFocalError, kGrossPrincipalPointError * model.fx,
                              kGrossPrincipalPointError * model.fy, kGrossRadialError);
  Eigen::Index which = 0;
  const double times = freed.correction.cwiseAbs().cwiseQuotient(gross).maxCoeff(&which);
  if (!(times > 1) || !(freed.significance > kMinSignificance)) {
    if (freed.converged) return std::nullopt;
    ModelMismatch unknown = make_intrinsic_mismatch(0, 0, camera, cameras.size());
    unknown.parameter.replace(0, std::string("focal length").size(), "set of intrinsics");
    unknown.significant = unknown.serious = unknown.gross = true;
    return unknown;
  }
  ModelMismatch mismatch = make_intrinsic_mismatch(static_cast<size_t>(which),
                                                   freed.correction(which), camera, cameras.size());
  mismatch.significance = freed.significance;
  mismatch.significant = mismatch.serious = mismatch.gross = true;
  return mismatch;
}

}  // namespace infuse::calibration
