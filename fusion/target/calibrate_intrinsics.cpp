#include "fusion/target/calibrate_intrinsics.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "drivers/measurement/angles.hpp"
#include "drivers/measurement/median.hpp"
#include "fusion/target/intrinsics_covariance.hpp"
#include "fusion/target/solve_intrinsics.hpp"

namespace infuse::target {
namespace {

constexpr int kOutlierRounds = 5;      // bounds time
constexpr double kOutlierSigma = 3.7;  // one in ten thousand of a Gaussian
constexpr double kSmallTilt = 15;  // °; names the advice only (Zhang 2000: the error of the focal
                                   // length falls until the boards are tilted by 45°)

std::string text(const char* format, auto... values) {
  char out[200];
  std::snprintf(out, sizeof out, format, values...);
  return out;
}

/// Errors of each view at a solution.
void evaluate_views(const Board& board, std::span<const Corners> views,
                    const IntrinsicsSolution& solution, IntrinsicsResult& result) {
  const geometry::CameraModel camera(solution.camera);
  for (size_t v = 0; v < views.size(); ++v) {
    IntrinsicsView& view = result.views[v];
    view.residual.resize(0);
    if (!solution.T_camera_board[v]) continue;
    const auto equations =
        linearize_corners(camera, board, solution.bow, *solution.T_camera_board[v], views[v]);
    if (!equations) continue;
    view.residual = equations->residual;
    view.rms = std::sqrt(view.residual.squaredNorm() / static_cast<double>(views[v].size()));
  }
}

/// Uses the views whose errors are as those of the others: the logarithm of their rms within
/// `kOutlierSigma` above the median, by the median deviation. Returns whether that changes any.
bool choose_inliers(const IntrinsicsResult& result, std::vector<bool>& used) {
  std::vector<double> logarithms;
  for (const IntrinsicsView& view : result.views) {
    if (view.residual.size() > 0) logarithms.push_back(std::log(std::max(view.rms, 1e-9)));
  }
  if (logarithms.empty()) return false;
  const double middle = median(std::vector<double>(logarithms));
  for (double& value : logarithms) value = std::abs(value - middle);
  // A share of corners' own noise: the rms of 2 n residuals is known to 1 / √(4 n).
  const auto corners = static_cast<double>(result.views.front().residual.size()) / 2;
  const double spread =
      std::max(1.4826 * median(std::move(logarithms)), 1 / std::sqrt(4 * std::max(corners, 9.0)));
  bool changed = false;
  for (size_t v = 0; v < result.views.size(); ++v) {
    const IntrinsicsView& view = result.views[v];
    const bool inlier = view.residual.size() > 0 &&
                        std::log(std::max(view.rms, 1e-9)) <= middle + kOutlierSigma * spread;
    changed = changed || inlier != used[v];
    used[v] = inlier;
  }
  return changed;
}

double largest_tilt(const std::vector<bool>& used, const IntrinsicsSolution& solution) {
  double cosine = 1;
  for (size_t a = 0; a < used.size(); ++a) {
    for (size_t b = 0; b < a; ++b) {
      if (!used[a] || !used[b]) continue;
      cosine = std::min(cosine, std::abs(solution.T_camera_board[a]->linear().col(2).dot(
                                    solution.T_camera_board[b]->linear().col(2))));
    }
  }
  return std::acos(std::clamp(cosine, -1.0, 1.0));
}

/// What to do about a number that the views do not determine.
std::string advice(const IntrinsicsResult& result) {
  const double tilt = result.tilt_spread / kDegree;
  if (tilt < kSmallTilt) {
    return text(
        ": all boards are within %.0f° of parallel; tilt the board by 20° to 45° to every side",
        std::ceil(tilt));
  }
  return ": add views, tilted by 20° to 45° to every side, that fill the image";
}

/// Names the number that is not known well enough; empty if all are.
std::string find_undetermined(const IntrinsicsResult& result,
                              const CalibrateIntrinsicsOptions& options) {
  if (result.covariance.size() == 0)
    return "the views do not determine the focal length" + advice(result);
  const double focal =
      std::max(result.sigma(0) / result.camera.fx, result.sigma(1) / result.camera.fy);
  if (!(focal <= options.max_focal_sigma)) {
    return text("the focal length is known to %.2g %% only (at most %.2g %%)", 100 * focal,
                100 * options.max_focal_sigma) +
           advice(result);
  }
  const double allowed = options.max_centre_sigma * std::min(result.camera.fx, result.camera.fy);
  const double centre = std::max(result.sigma(2), result.sigma(3));
  if (!(centre <= allowed)) {
    return text("the principal point is known to %.2g px only (at most %.2g px)", centre, allowed) +
           advice(result);
  }
  return "";
}

std::string find_reason(const IntrinsicsResult& result, bool converged,
                        const CalibrateIntrinsicsOptions& options) {
  const size_t rejected = result.views.size() - result.used;
  if (static_cast<double>(rejected) >
      options.max_rejected * static_cast<double>(result.views.size())) {
    return text("%zu of %zu views do not fit the others: another board, or not this model",
                rejected, result.views.size());
  }
  if (result.used < options.min_views) {
    return text("%zu views of the board, at least %zu are needed", result.used, options.min_views);
  }
  if (!converged) return "the least squares did not converge" + advice(result);
  if (!(result.rms <= options.max_rms)) {
    return text("corners are off by %.2g px (at most %.2g px): another board, or not this model",
                result.rms, options.max_rms);
  }
  return find_undetermined(result, options);
}

}  // namespace

std::optional<std::string> CalibrateIntrinsicsOptions::invalid() const {
  if (min_views < 3) return "min_views must be at least 3";
  if (!(max_rejected >= 0 && max_rejected < 1)) return "max_rejected must be between 0 and 1";
  if (!(max_rms > 0) || !(max_focal_sigma > 0) || !(max_centre_sigma > 0) || !(flatness > 0))
    return "limits must be positive";
  return std::nullopt;
}

double IntrinsicsResult::sigma(int number) const {
  return covariance.size() == 0 ? std::numeric_limits<double>::infinity()
                                : std::sqrt(covariance(number, number));
}

IntrinsicsResult calibrate_intrinsics(const CameraIntrinsics& camera, const Board& board,
                                      std::span<const Corners> views,
                                      const CalibrateIntrinsicsOptions& options) {
  IntrinsicsResult result;
  result.camera = camera;
  result.views.resize(views.size());
  if (views.size() < options.min_views) {
    result.used = 0;
    result.reason =
        text("%zu views of the board, at least %zu are needed", views.size(), options.min_views);
    return result;
  }
  auto solution = guess_intrinsics(camera, board, views);
  if (!solution) {
    result.reason = "no focal length fits the boards: another board, or not this model";
    return result;
  }
  std::vector<bool> used(views.size());
  for (size_t v = 0; v < views.size(); ++v) used[v] = solution->T_camera_board[v].has_value();
  IntrinsicsWeights weights{.flatness = options.flatness, .robust_rms = options.max_rms};
  IntrinsicsCovariance known;
  for (int round = 0; round < kOutlierRounds; ++round) {
    solve_intrinsics(board, views, used, weights, *solution);
    evaluate_views(board, views, *solution, result);
    known = estimate_intrinsics_covariance(board, views, used, options.flatness, *solution);
    // What is stated is of the last solution: no view changes after it.
    if (round + 1 == kOutlierRounds || (!choose_inliers(result, used) && round > 0)) break;
    weights.robust_rms = 0;
    weights.corner_noise = std::max(known.corner_noise, 1e-3);
  }
  result.camera = solution->camera;
  result.covariance = known.covariance;
  result.corner_noise = known.corner_noise;
  result.view_ratio = known.view_ratio;
  result.bow = solution->bow.cwiseAbs().maxCoeff();
  result.tilt_spread = largest_tilt(used, *solution);
  result.coverage = measure_coverage(solution->camera, views, used);
  double squares = 0, corners = 0;
  for (size_t v = 0; v < views.size(); ++v) {
    result.views[v].used = used[v];
    if (!used[v]) continue;
    ++result.used;
    squares += result.views[v].residual.squaredNorm();
    corners += static_cast<double>(views[v].size());
  }
  result.rms = corners > 0 ? std::sqrt(squares / corners) : 0;
  result.reason = find_reason(result, solution->converged, options);
  return result;
}

}  // namespace infuse::target
