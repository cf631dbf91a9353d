#include "fusion/calibration/free_intrinsics.hpp"

#include <algorithm>
#include <cmath>

#include "fusion/calibration/ascent.hpp"

namespace infuse::calibration {
namespace {

using geometry::Vector6;
using Vector10 = Parameters<10>;

struct FreeLevel {
  double sigma;   // px
  size_t points;  // at most
};
constexpr FreeLevel kLevels[] = {{8, 15'000}, {4, 30'000}, {2, 60'000}, {1, 60'000}};
constexpr AscentOptions kAscent{.max_iterations = 50, .tolerance = 1e-2};
constexpr double kAngle = 0.01;    // rad; steps of this,
constexpr double kLength = 0.1;    // m, of this,
constexpr double kFocal = 0.02;    // of this in the logarithm of the focal lengths,
constexpr double kCentre = 0.015;  // of this many focal lengths of the principal point
constexpr double kRadial = 0.03;   // and of this in k1 are taken to matter alike
constexpr double kAnchor = 0.02;   // share of the measure that is taken off …
constexpr double kAnchored = 5;    // … where an intrinsic is so many of these steps off

constexpr int kFewest = 8;             // scenes
constexpr size_t kFewestPoints = 200;  // of a scene
constexpr double kSerious = 4;         // standard errors
constexpr double kGrossFocal = 0.02;
constexpr double kGrossCentre = 0.015;  // focal lengths
constexpr double kGrossRadial = 0.04;

/// A pose and a camera's intrinsics in ten scaled numbers, 0 where they started. The principal
/// point takes along the rotation that keeps the picture's middle where it is: alone it would lead
/// along a narrow ridge.
class Freed {
 public:
  Freed(std::span<const RigCamera> cameras, size_t camera, const Eigen::Isometry3d& T)
      : given_(cameras.begin(), cameras.end()), camera_(camera), T_(T) {
    const CameraIntrinsics& model = cameras[camera].model.intrinsics();
    scale_ << Eigen::Vector3d::Constant(kAngle), Eigen::Vector3d::Constant(kLength), kFocal,
        kCentre * model.fx, kCentre * model.fy, kRadial;
    const geometry::Matrix6 to_head = geometry::adjoint(cameras[camera].T_camera_head.inverse());
    turn_across_ = to_head * Vector6::Unit(1) / -model.fx;
    turn_down_ = to_head * Vector6::Unit(0) / model.fy;
  }

  Eigen::Isometry3d pose(const Vector10& d) const { return geometry::exp(xi(d)) * T_; }

  Eigen::Vector4d off(const Vector10& d) const { return scale_.cwiseProduct(d).tail<4>(); }

  std::vector<RigCamera> cameras(const Vector10& d) const {
    const Eigen::Vector4d by = off(d);
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

  /// The sum of what scenes of this camera or of others pull, in these numbers.
  Vector10 slope(const Vector10& d, std::span<const ScenePull> pulls,
                 std::span<const Scene> scenes) const {
    Vector10 sum = Vector10::Zero();
    for (size_t s = 0; s < pulls.size(); ++s) {
      sum.head<6>() += pulls[s].head<6>();
      if (scenes[s].camera == camera_) sum.tail<4>() += pulls[s].tail<4>();
    }
    sum.head<6>() = (geometry::left_jacobian(xi(d)).transpose() * sum.head<6>()).eval();
    sum(7) += turn_across_.dot(sum.head<6>());
    sum(8) += turn_down_.dot(sum.head<6>());
    return sum.cwiseProduct(scale_);
  }

 private:
  Vector6 xi(const Vector10& d) const {
    const Vector10 s = scale_.cwiseProduct(d);
    return s.head<6>() + s(7) * turn_across_ + s(8) * turn_down_;
  }

  std::vector<RigCamera> given_;
  size_t camera_;
  Eigen::Isometry3d T_;
  Vector10 scale_;
  Vector6 turn_across_, turn_down_;
};

/// How much better each of the camera's scenes fits, on points chosen as given.
std::vector<double> gains(const VisiblePoints& points, const BlurredImages& images,
                          std::span<const Scene> scenes, std::span<const RigCamera> given,
                          const Eigen::Isometry3d& T_given, std::span<const RigCamera> found,
                          const Eigen::Isometry3d& T_found, size_t camera,
                          std::span<const TermOptions> terms) {
  std::vector<double> all;
  for (const VisiblePoints::Block& block : points.blocks) {
    if (block.end - block.begin < kFewestPoints || scenes[block.scene].camera != camera) continue;
    const VisiblePoints own = only(points, std::span(&block, 1));
    Objective measure(own, images, given, scenes, terms);
    const double before = measure.evaluate(T_given, false).estimate.value;
    measure.look_through(found);
    all.push_back(measure.evaluate(T_found, false).estimate.value - before);
  }
  return all;
}

}  // namespace

std::optional<FreedIntrinsics> free_intrinsics(
    std::span<const Scene> scenes, std::span<const RigCamera> cameras, size_t camera,
    std::span<const TermOptions> terms, ImagePyramid& images, const VisibilityOptions& visibility,
    const Eigen::Isometry3d& T_head_lidar, const std::stop_token& stop) {
  if (std::count_if(scenes.begin(), scenes.end(),
                    [&](const Scene& scene) { return scene.camera == camera; }) < kFewest) {
    return std::nullopt;
  }
  const Freed freed(cameras, camera, T_head_lidar);
  Vector10 at = Vector10::Zero();
  VisibilityOptions thinned = visibility;
  for (const FreeLevel& level : kLevels) {
    thinned.max_points = level.points;
    std::vector<RigCamera> through = freed.cameras(at);
    const VisiblePoints points = select_visible(scenes, through, freed.pose(at), thinned);
    Objective objective(points, images.at(level.sigma), through, scenes, terms);
    const double all = std::max(0.0, objective.evaluate(freed.pose(at), false).estimate.value);
    const double weight = 2 * kAnchor * all / (kAnchored * kAnchored);
    const Vector10 from = at;
    const auto value = [&](const Vector10& step, Vector10* slope) {
      const Vector10 d = from + step;
      Vector10 held = weight * d;
      held.head<6>().setZero();
      through = freed.cameras(d);
      objective.look_through(through);
      dependence::Estimate estimate;
      const std::vector<ScenePull> pulls = objective.scene_pulls(freed.pose(d), &estimate);
      *slope = freed.slope(d, pulls, scenes) - held;
      return estimate.value - 0.5 * held.dot(d);
    };
    at = from + ascend_ten(value, kAscent).d;
    if (stop.stop_requested()) return std::nullopt;
  }
  FreedIntrinsics out{.T_head_lidar = freed.pose(at), .off = freed.off(at)};
  const std::vector<double> gain =
      gains(select_visible(scenes, cameras, T_head_lidar, thinned),
            images.at(std::end(kLevels)[-1].sigma), scenes, cameras, T_head_lidar,
            freed.cameras(at), out.T_head_lidar, camera, terms);
  out.scenes = static_cast<int>(gain.size());
  if (out.scenes < kFewest) return std::nullopt;
  double sum = 0, squares = 0;
  for (const double one : gain) {
    sum += one;
    out.better += one > 0 ? 1 : 0;
  }
  const double n = out.scenes;
  for (const double one : gain) squares += (one - sum / n) * (one - sum / n);
  out.significance = squares > 0 ? sum / std::sqrt(n / (n - 1) * squares) : 0;
  return out;
}

std::optional<ModelDoubt> gross_doubt(const FreedIntrinsics& freed,
                                      std::span<const RigCamera> cameras, size_t camera) {
  const CameraIntrinsics& model = cameras[camera].model.intrinsics();
  const Eigen::Vector4d gross(kGrossFocal, kGrossCentre * model.fx, kGrossCentre * model.fy,
                              kGrossRadial);
  Eigen::Index which = 0;
  const double times = freed.off.cwiseAbs().cwiseQuotient(gross).maxCoeff(&which);
  if (!(times > 1) || !(freed.significance > kSerious)) return std::nullopt;
  ModelDoubt doubt =
      doubt_about(static_cast<size_t>(which), freed.off(which), camera, cameras.size());
  doubt.significance = freed.significance;
  doubt.doubtful = doubt.serious = doubt.gross = true;
  return doubt;
}

}  // namespace infuse::calibration
