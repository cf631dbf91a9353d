#include "tests/bench/streetmap_runs.hpp"

#include <cmath>
#include <ctime>
#include <span>
#include <utility>

namespace infuse::streetmap::bench {
namespace {

constexpr size_t kSettlingViews = 10;   // views that do not count
constexpr double kChiSquared99 = 9.21;  // χ² of two
constexpr double kMaxTrackedError = 3;  // m
constexpr double kMaxSuccessError = 2;  // m, I 3.4.3.3
constexpr double kBadHdop = 15;
constexpr double kMaxPlaceError = 12;  // m
constexpr double kMinCourseSpeed =
    2;  // m/s, as in the daemon (daemon/pipeline/street_map_fixes.cpp)
constexpr double kCourseSigma = 0.05;  // rad

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

double square(double x) { return x * x; }

}  // namespace

RunResult run(const SegmentMap& map, const std::vector<View>& all, const RunOptions& options) {
  const size_t first = std::min(options.first_view, all.size() - 1);
  const std::span<const View> views =
      std::span(all).subspan(first, std::min(options.max_views, all.size() - first));
  std::mt19937_64 random(options.seed * 7919);
  std::normal_distribution<double> normal;
  const double scale = 1 + options.scale_sigma * normal(random),
               rate = options.yaw_bias_sigma * normal(random);
  TrackerOptions settings = options.tracker;
  settings.seed = options.seed * 77;
  Tracker tracker(map, settings, options.score ? options.score() : nullptr);
  const double direction = 10 * normal(random);
  PlanarPose initial_pose = views.front().truth;
  initial_pose.x += options.initial_error * std::cos(direction);
  initial_pose.y += options.initial_error * std::sin(direction);
  initial_pose.yaw += options.initial_yaw_sigma * normal(random);
  if (options.start_offset) initial_pose = views.front().truth.compose(*options.start_offset);
  if (options.start_pose) initial_pose = *options.start_pose;
  const Eigen::Vector2d gnss_error =
      options.gnss_offset +
      options.gnss_sigma.value_or(0) * Eigen::Vector2d(normal(random), normal(random));
  const double sigma = std::max(options.initial_error, 0.5);
  const Eigen::Vector3d variances(square(sigma), square(sigma), square(options.initial_yaw_sigma));
  if (!options.from_nothing) tracker.start(initial_pose, variances.asDiagonal());
  RunResult result;
  double lateral = 0, longitudinal = 0, yaw = 0, counted = 0;
  double driven_metres = 0, outside_since = -1;
  size_t recovered_at = SIZE_MAX;  // view
  const double began = cpu_seconds();
  for (size_t i = 0; i < views.size(); ++i) {
    double speed = 0;
    if (i > 0) {
      const PlanarPose true_motion = views[i - 1].truth.motion_to(views[i].truth);
      const double step = views[i].seconds - views[i - 1].seconds;
      const double driven = std::hypot(true_motion.x, true_motion.y);
      driven_metres += driven;
      speed = driven / step;
      // The relative standard deviation of a sum of independent motions is smaller.
      const double share = 1 / std::sqrt(std::max(std::round(step * options.noise_hz), 1.0));
      const double distance_noise = share * options.distance_noise * driven;
      const double turn_noise = share * options.yaw_rate_noise * step;
      PlanarPose motion = true_motion;
      motion.x =
          scale * true_motion.x + (distance_noise + 0.005 * std::sqrt(driven)) * normal(random);
      motion.y += 0.003 * std::sqrt(driven) * normal(random);
      motion.yaw += rate * step + (turn_noise + 5e-4 * std::sqrt(step)) * normal(random);
      const Eigen::Vector3d noise(square(distance_noise), 0, square(turn_noise));
      tracker.predict(motion, noise.asDiagonal(), from_seconds(step));
    }
    if (options.gnss_sigma) {
      MapFix fix;
      fix.position = Eigen::Vector2d(views[i].truth.x, views[i].truth.y) + gnss_error +
                     Eigen::Vector2d(normal(random), normal(random));
      if (speed >= kMinCourseSpeed) fix.yaw = views[i].truth.yaw + kCourseSigma * normal(random);
      if (std::cmp_less(i, options.bad_fixes)) {
        fix.position += options.bad_fix_offset;
        fix.hdop = kBadHdop;
      }
      tracker.add_fix(fix);
    }
    tracker.update(views[i].samples);
    const TrackerEstimate estimate = tracker.estimate();
    const PlanarPose error = views[i].truth.motion_to(estimate.pose);
    ++result.updates;
    if (tracker.started() && result.started_metres < 0 &&
        std::hypot(error.x, error.y) < kMaxPlaceError) {
      result.started_metres = driven_metres;
    }
    result.lost += estimate.state == TrackState::kLost;
    if (estimate.state != TrackState::kTracking) ++result.doubts[estimate.reason];
    const double now = views[i].seconds - views.front().seconds;
    bool outside = false;
    if (estimate.state == TrackState::kTracking) {
      ++result.tracking;
      if (result.metres_to_tracking < 0) {
        result.metres_to_tracking = driven_metres;
        result.seconds_to_tracking = now;
      }
      const Eigen::Vector2d d(estimate.pose.x - views[i].truth.x,
                              estimate.pose.y - views[i].truth.y);
      const Eigen::Matrix2d C = estimate.covariance.topLeftCorner<2, 2>();
      outside = d.dot(C.inverse() * d) >= kChiSquared99;
      result.inside_99 += !outside;
    }
    result.updates_since_tracking += result.metres_to_tracking >= 0;
    outside_since = !outside ? -1 : outside_since < 0 ? now : outside_since;
    if (outside) result.longest_outside = std::max(result.longest_outside, now - outside_since);
    result.final_error = std::hypot(error.x, error.y);
    result.tracks_truth =
        estimate.state == TrackState::kTracking && result.final_error < kMaxTrackedError;
    if (result.tracks_truth && recovered_at == SIZE_MAX) {
      recovered_at = i;
      result.recovered_after = now;
    }
    if (i - recovered_at >= options.views_after_recovery && i >= recovered_at) break;
    if (i < kSettlingViews) continue;
    ++counted;
    lateral += square(error.y);
    longitudinal += square(error.x);
    yaw += square(error.yaw);
  }
  result.seconds = (cpu_seconds() - began) / std::max(result.updates, 1);
  result.lateral = std::sqrt(lateral / counted);
  result.longitudinal = std::sqrt(longitudinal / counted);
  result.total = std::sqrt((lateral + longitudinal) / counted);
  result.yaw = std::sqrt(yaw / counted);
  return result;
}

Summary run_seeds(const SegmentMap& map, const std::vector<View>& views, RunOptions options,
                  int seeds) {
  Summary summary;
  double updates = 0, tracking = 0, within = 0, lost = 0, squares = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    options.seed = static_cast<uint64_t>(seed);
    const RunResult result = run(map, views, options);
    summary.lateral += result.lateral / seeds;
    summary.longitudinal += result.longitudinal / seeds;
    summary.total += result.total / seeds;
    squares += square(result.total) / seeds;
    summary.yaw += result.yaw / seeds;
    summary.success += (result.final_error < kMaxSuccessError ? 1.0 : 0.0) / seeds;
    summary.seconds += result.seconds / seeds;
    updates += result.updates;
    tracking += result.tracking;
    within += result.inside_99;
    lost += result.lost;
    for (const auto& [reason, count] : result.doubts) summary.doubts[reason] += count;
  }
  for (auto& [reason, share] : summary.doubts) share /= updates;
  summary.total_sigma = std::sqrt(std::max(squares - square(summary.total), 0.0));
  summary.tracking = tracking / updates;
  summary.lost = lost / updates;
  summary.inside_99 = tracking > 0 ? within / tracking : 1;
  summary.runs = seeds;
  return summary;
}

}  // namespace infuse::streetmap::bench
