#include "daemon/pipeline/map_tracker.hpp"

#include <cmath>
#include <numbers>

#include "drivers/measurement/angles.hpp"

namespace infuse::daemon {
namespace {

constexpr int kImageStep = 2;             // pixels that become one of the features
constexpr double kMinCourseSpeed = 2.0;   // m/s from which on a receiver's course is the heading
constexpr double kFixSigma = 3.0;         // m
constexpr double kCourseSigma = 0.1;      // rad
constexpr double kScaleSigma = 0.006;     // m a metre, odometry's scale
constexpr double kRestSigma = 0.005;      // m
constexpr double kYawRateSigma = 0.002;   // rad/s, odometry's bias
constexpr double kNoOdometrySigma = 3.0;  // m that the vehicle may go where odometry says nothing
constexpr double kNoOdometryYawSigma = 0.2;  // rad, the same

streetmap::PlanarPose planar(const Eigen::Isometry3d& T) {
  return {T.translation().x(), T.translation().y(), std::atan2(T(1, 0), T(0, 0))};
}

/// Noise of one step, of x, y and yaw. The covariance of a motion is how much that of the pose grew
/// (Trajectory::between); with errors that last, a scale or a bias, it grows ever faster, and to
/// draw it anew at each step would count them many times: the particles carry those. Within one
/// step errors do no more than a wrong scale and a wrong rate can: deviations are held to that.
Eigen::Matrix3d step_noise(const geometry::MotionBetween& motion, Duration step) {
  constexpr int kOrder[3] = {3, 4, 2};
  const double distance = motion.T_from_to.translation().norm();
  const double max_sigma[3] = {kScaleSigma * distance + kRestSigma,
                               kScaleSigma * distance + kRestSigma,
                               kYawRateSigma * to_seconds(step)};
  Eigen::Matrix3d result;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) result(i, k) = motion.covariance(kOrder[i], kOrder[k]);
  }
  for (int i = 0; i < 3; ++i) {
    const double sigma = std::sqrt(std::max(result(i, i), 0.0));
    if (sigma <= max_sigma[i]) continue;
    result.row(i) *= max_sigma[i] / sigma;
    result.col(i) *= max_sigma[i] / sigma;
  }
  return result;
}

Eigen::Matrix3d diagonal(double metres, double yaw) {
  return Eigen::Vector3d(metres * metres, metres * metres, yaw * yaw).asDiagonal();
}

}  // namespace

MapTracker::MapTracker(const StreetMapSettings& settings, const streetmap::SegmentMap& map,
                       const Rig& rig)
    : settings_(settings), rig_(rig), tracker_(map, settings.tracker) {
  for (const CameraMount& camera : rig.cameras) cameras_.emplace_back(camera.intrinsics);
  const streetmap::MapFrame& frame = map.frame();
  if (frame.georeferenced) frame_ = gnss::make_local_frame(frame.latitude, frame.longitude);
  initialise();
}

void MapTracker::initialise() {
  if (!settings_.initial_pose) return;
  const InitialPose& start = *settings_.initial_pose;
  tracker_.start({start.x, start.y, start.yaw},
                 diagonal(settings_.initial_sigma, settings_.initial_yaw_sigma));
  initialised_ = true;
}

void MapTracker::add_gnss(const GnssFix& fix) {
  const bool known = fix.valid && std::isfinite(fix.latitude) && std::isfinite(fix.longitude) &&
                     std::isfinite(fix.course) && fix.speed >= kMinCourseSpeed;
  if (initialised_ || !frame_ || !known) return;
  const Eigen::Vector3d place = gnss::to_local(*frame_, fix.latitude, fix.longitude);
  tracker_.start({place.x(), place.y(), wrap_angle(std::numbers::pi / 2 - fix.course)},
                 diagonal(kFixSigma, kCourseSigma));
  initialised_ = true;
}

void MapTracker::predict_to(Stamp stamp, const geometry::Trajectory& trajectory) {
  if (now_ != Stamp::earliest() && stamp > now_) {
    const geometry::MotionBetween motion = trajectory.between(now_, stamp);
    if (motion.usable()) {
      tracker_.predict(planar(motion.T_from_to), step_noise(motion, stamp - now_), stamp - now_);
    } else {
      tracker_.predict({}, diagonal(kNoOdometrySigma, kNoOdometryYawSigma), stamp - now_);
    }
  }
  now_ = stamp;
}

void MapTracker::add_sweep(const Sweep& sweep, const motion::DeskewedSweep& deskewed, size_t lidar,
                           const geometry::Trajectory& trajectory) {
  predict_to(deskewed.reference, trajectory);
  if (!deskewed.usable()) return;
  tracker_.add_sweep(
      {sweep, deskewed.x, deskewed.y, deskewed.z, rig_.lidars[lidar].T_vehicle_lidar}, nullptr);
  if (now_ < next_update_ && next_update_ - now_ < Duration(5'000'000'000)) return;
  tracker_.update();
  ++updates_;
  next_update_ = now_ + from_seconds(1 / settings_.update_hz);
}

void MapTracker::add_image(const CameraFrame& frame, Stamp exposure, size_t camera, size_t lidar,
                           const Sweep& sweep, const motion::DeskewedSweep& deskewed,
                           const geometry::Trajectory& trajectory) {
  const geometry::MotionBetween back = trajectory.between(now_, exposure);
  if (!deskewed.usable() || !back.usable()) return;
  if (!streetmap::extract_features(frame, kImageStep, features_)) return;
  const streetmap::ImageView image{features_, cameras_[camera],
                                   rig_.cameras[camera].T_camera_lidar};
  tracker_.add_sweep(
      {sweep, deskewed.x, deskewed.y, deskewed.z, rig_.lidars[lidar].T_vehicle_lidar}, &image,
      planar(back.T_from_to));
}

PoseReport MapTracker::pose(const PoseReport& odometry) const {
  const streetmap::TrackerEstimate estimate = tracker_.estimate();
  PoseReport report = odometry;
  report.frame = "map";
  report.T_frame_vehicle = estimate.T_map_vehicle();
  report.covariance = estimate.pose_covariance();
  report.state = streetmap::name(estimate.state);
  report.p_value = estimate.p_value;
  report.entropy = estimate.entropy;
  report.reason = "";
  if (!estimate.usable()) {
    report.reason = *estimate.reason != '\0' ? estimate.reason : "lost";
  }
  return report;
}

StreetMapStatus MapTracker::status() const {
  const streetmap::TrackerEstimate estimate = tracker_.estimate();
  StreetMapStatus figures;
  figures.state = streetmap::name(estimate.state);
  figures.reason = estimate.reason;
  figures.x = estimate.pose.x;
  figures.y = estimate.pose.y;
  figures.p_value = estimate.p_value;
  figures.entropy = estimate.entropy;
  figures.particles = estimate.particles;
  figures.updates = updates_;
  // Before the null distribution has settled nothing can be said of the map.
  figures.mismatch = initialised_ &&
                     updates_ >= static_cast<uint64_t>(settings_.tracker.confidence.window) &&
                     estimate.p_value > settings_.tracker.confidence.max_tracking_p_value;
  return figures;
}

}  // namespace infuse::daemon
