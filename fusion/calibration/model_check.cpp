#include "fusion/calibration/model_check.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::calibration {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

constexpr size_t kFewest = 10;     // scenes
constexpr double kDoubtful = 3.5;  // standard deviations
constexpr double kSerious = 7;

/// One of a camera's numbers.
struct Intrinsic {
  const char* name;
  const char* unit;
  double shown;    // units a unit of the derivative
  double step;     // of the differences
  double careful;  // what a good calibration of the camera leaves, in `unit`
};

constexpr Intrinsic kIntrinsics[] = {{"focal length", "%", 100, 2e-3, 0.3},
                                     {"principal point, across", "px", 1, 1, 3},
                                     {"principal point, down", "px", 1, 1, 3},
                                     {"radial distortion k1", "", 1, 4e-3, 0.01}};
constexpr double kCarefulTime = 5;  // ms

CameraIntrinsics with(CameraIntrinsics camera, size_t which, double step) {
  switch (which) {
    case 0:
      camera.fx *= std::exp(step);
      camera.fy *= std::exp(step);
      break;
    case 1:
      camera.cx += step;
      break;
    case 2:
      camera.cy += step;
      break;
    default:
      camera.distortion[0] += step;
  }
  return camera;
}

/// What the scenes say of a further parameter: an entry a scene, and minus the second derivatives.
struct Further {
  std::vector<double> pull;
  Vector6 with_pose = Vector6::Zero();
  double curvature = 0;
};

/// Value, standard deviation and significance.
ModelDoubt judge(const Further& further, const std::vector<ScenePull>& pulls,
                 const Matrix6& inverse) {
  const Vector6 weight = inverse * further.with_pose;
  std::vector<double> scores;
  double sum = 0;
  for (size_t s = 0; s < pulls.size(); ++s) {
    if (pulls[s].head<6>() == Vector6::Zero()) continue;
    scores.push_back(further.pull[s] - weight.dot(pulls[s].head<6>()));
    sum += scores.back();
  }
  const auto n = static_cast<double>(scores.size());
  double squares = 0;
  for (const double score : scores) squares += (score - sum / n) * (score - sum / n);
  const double deviation = std::sqrt(n / (n - 7) * squares);
  const double left = further.curvature - further.with_pose.dot(weight);
  ModelDoubt doubt;
  doubt.moves = -weight;
  if (!(deviation > 0)) return doubt;
  doubt.significance = sum / deviation;
  if (left > 0) {
    doubt.value = sum / left;
    doubt.sigma = deviation / left;
  }
  return doubt;
}

Further intrinsic(Objective& objective, const Eigen::Isometry3d& T,
                  std::span<const RigCamera> cameras, std::span<const Scene> scenes, size_t camera,
                  size_t which, const std::vector<ScenePull>& pulls) {
  const auto row = static_cast<Eigen::Index>(6 + which);
  const double step = kIntrinsics[which].step;
  Further out;
  for (size_t s = 0; s < pulls.size(); ++s) {
    out.pull.push_back(scenes[s].camera == camera ? pulls[s](row) : 0.0);
  }
  for (const double side : {-1.0, 1.0}) {
    std::vector<RigCamera> other(cameras.begin(), cameras.end());
    other[camera].model =
        geometry::CameraModel(with(cameras[camera].model.intrinsics(), which, side * step));
    objective.look_through(other);
    const std::vector<ScenePull> there = objective.scene_pulls(T);
    for (size_t s = 0; s < there.size(); ++s) {
      out.with_pose -= side / (2 * step) * there[s].head<6>();
      if (scenes[s].camera == camera) out.curvature -= side / (2 * step) * there[s](row);
    }
  }
  objective.look_through(cameras);
  return out;
}

/// A picture that was taken dt later saw p from exp(ξ dt) further on: T exp(−ξ dt) p.
Further delay(const Eigen::Isometry3d& T, std::span<const Scene> scenes,
              const Uncertainty& uncertainty) {
  const Matrix6 adjoint = geometry::adjoint(T);
  Further out;
  for (size_t s = 0; s < scenes.size(); ++s) {
    const Vector6 moves = -adjoint * *scenes[s].twist;
    out.pull.push_back(moves.dot(uncertainty.pulls[s].head<6>()));
    const Matrix6 H = uncertainty.scene_curvature[s].topRows<6>();
    out.with_pose += 0.5 * (H + H.transpose()) * moves;
    out.curvature += moves.dot(H * moves);
  }
  return out;
}

}  // namespace

ModelDoubt doubt_about(size_t intrinsic, double off, size_t camera, size_t cameras) {
  const Intrinsic& of = kIntrinsics[intrinsic];
  return {
      .what = std::string(of.name) + (cameras > 1 ? " of camera " + std::to_string(camera) : ""),
      .unit = of.unit,
      .value = of.shown * off};
}

std::vector<ModelDoubt> check_model(Objective& objective, const Eigen::Isometry3d& T_head_lidar,
                                    std::span<const RigCamera> cameras,
                                    std::span<const Scene> scenes, const Uncertainty& uncertainty) {
  const std::vector<ScenePull>& pulls = uncertainty.pulls;
  const auto seen = std::count_if(pulls.begin(), pulls.end(), [](const ScenePull& p) {
    return p.head<6>() != Vector6::Zero();
  });
  std::vector<ModelDoubt> doubts;
  if (!uncertainty.usable() || static_cast<size_t>(seen) < kFewest) return doubts;
  const Matrix6 inverse = uncertainty.curvature.inverse();
  const auto add = [&](const Further& further, const ModelDoubt& about, double shown,
                       double careful) {
    ModelDoubt doubt = judge(further, pulls, inverse);
    doubt.what = about.what;
    doubt.unit = about.unit;
    doubt.value *= shown;
    doubt.sigma *= shown;
    doubt.moves /= shown;
    const bool careless = doubt.value == 0 || std::abs(doubt.value) > careful;
    doubt.doubtful = careless && std::abs(doubt.significance) > kDoubtful;
    doubt.serious = careless && std::abs(doubt.significance) > kSerious;
    doubts.push_back(doubt);
  };
  for (size_t c = 0; c < cameras.size(); ++c) {
    for (size_t which = 0; which < std::size(kIntrinsics); ++which) {
      const Intrinsic& of = kIntrinsics[which];
      add(intrinsic(objective, T_head_lidar, cameras, scenes, c, which, pulls),
          doubt_about(which, 0, c, cameras.size()), of.shown, of.careful);
    }
  }
  const bool moving = std::all_of(scenes.begin(), scenes.end(),
                                  [](const Scene& scene) { return scene.twist.has_value(); });
  if (moving) {
    add(delay(T_head_lidar, scenes, uncertainty), {.what = "time of the pictures", .unit = "ms"},
        1e3, kCarefulTime);
  }
  return doubts;
}

}  // namespace infuse::calibration
