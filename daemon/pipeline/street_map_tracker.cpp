#include "daemon/pipeline/street_map_tracker.hpp"

#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "daemon/pipeline/unknown_pose.hpp"
#include "drivers/gnss/local_frame.hpp"
#include "fusion/geometry/plane_length.hpp"

namespace infuse::daemon {
namespace {

constexpr int kImageStep = 2;                      // pixels of the image for one of the features
constexpr Duration kMaxUpdateWait{5'000'000'000};  // ns; more remains after a jump back in time
constexpr double kCourseSigma = 0.1;               // rad

/// A pose on one map as one on another; nothing where they have nothing in common.
std::optional<streetmap::PlanarPose> moved(const streetmap::PlanarPose& pose,
                                           const streetmap::MapFrame& from,
                                           const streetmap::MapFrame& to) {
  if (from.georeferenced != to.georeferenced) return std::nullopt;
  if (!from.georeferenced) return from == to ? std::optional(pose) : std::nullopt;
  const auto source = gnss::make_local_frame(from.latitude, from.longitude);
  const auto target = gnss::make_local_frame(to.latitude, to.longitude);
  const auto place = [&](const Eigen::Vector2d& at) -> Eigen::Vector2d {
    const Eigen::Vector3d earth = gnss::to_geodetic(source, {at.x(), at.y(), 0});
    return gnss::to_local(target, earth.x(), earth.y()).head<2>();
  };
  constexpr double kAhead = 100;  // m: north is another direction at another longitude
  const Eigen::Vector2d here = place({pose.x, pose.y}),
                        ahead = place(pose.transform({kAhead, 0})) - here;
  return streetmap::PlanarPose{here.x(), here.y(), std::atan2(ahead.y(), ahead.x())};
}

Eigen::Matrix3d diagonal(double metres, double yaw) {
  return Eigen::Vector3d(metres * metres, metres * metres, yaw * yaw).asDiagonal();
}

}  // namespace

StreetMapTracker::StreetMapTracker(const StreetMapSettings& settings, StreetMapFile map,
                                   const Rig& rig)
    : settings_(settings),
      rig_(rig),
      map_(std::move(map)),
      tracker_(std::make_unique<streetmap::Tracker>(map_.map, settings.tracker)) {
  for (const CameraMount& camera : rig.cameras) cameras_.emplace_back(camera.intrinsics);
  const streetmap::MapFrame& frame = map_.map.frame();
  if (frame.georeferenced) fixes_.emplace(gnss::make_local_frame(frame.latitude, frame.longitude));
  if (const auto start = stated_start(settings, frame))
    tracker_->start(start->pose, diagonal(settings.initial_sigma, start->yaw_sigma));
}

void StreetMapTracker::go_on_from(const StreetMapTracker& before) {
  motion_ = before.motion_;
  next_update_ = before.next_update_;
  const streetmap::TrackerEstimate estimate = before.tracker_->estimate();
  if (!before.started() || !estimate.usable()) return;
  const auto pose = moved(estimate.pose, before.map_.map.frame(), map_.map.frame());
  if (pose) tracker_->start(*pose, estimate.covariance);
}

void StreetMapTracker::add_gnss(const GnssFix& fix) {
  if (fixes_) fixes_->add(fix);
}

// Each fix weighs the places that are searched, those of few satellites too; only of good ones,
// which particles reach, the track starts.
void StreetMapTracker::use_fixes(const geometry::Trajectory& trajectory) {
  if (!fixes_) return;
  const auto initial =
      tracker_->started() ? std::nullopt : fixes_->initial_pose(motion_.now(), trajectory);
  if (initial) {
    const streetmap::GnssOptions& gnss = settings_.tracker.gnss;
    tracker_->start(initial->pose, diagonal(geometry::plane_length(gnss.map_sigma,
                                                                   gnss.slow_sigma * initial->hdop),
                                            kCourseSigma));
  }
  while (const auto fix = fixes_->take(motion_.now(), tracker_->estimate().pose.yaw, trajectory)) {
    tracker_->add_fix(*fix);
  }
}

PoseReport StreetMapTracker::process(const SweepSnapshot& snapshot,
                                     const geometry::Trajectory& trajectory,
                                     const geometry::PoseAt& predicted,
                                     const PoseReport& odometry) {
  motion_.predict(*tracker_, trajectory, predicted, snapshot.deskewed.reference);
  use_fixes(trajectory);
  if (snapshot.deskewed.usable()) {
    tracker_->add_sweep(view(snapshot), nullptr);
    update_if_due();
  }
  return pose(odometry);
}

void StreetMapTracker::update_if_due() {
  if (motion_.now() < next_update_ && next_update_ - motion_.now() < kMaxUpdateWait) return;
  tracker_->update();
  ++updates_;
  next_update_ = motion_.now() + from_seconds(1 / settings_.update_hz);
}

void StreetMapTracker::add_image(const ImageMatch& match, const geometry::Trajectory& trajectory) {
  const geometry::MotionBetween back = trajectory.between(motion_.now(), match.image.stamp);
  if (!match.snapshot.deskewed.usable() || !back.usable()) return;
  if (!streetmap::extract_features(match.image.frame, kImageStep, features_)) return;
  const streetmap::ImageView image{features_, cameras_[match.image.camera], match.T_camera_lidar};
  tracker_->add_sweep(view(match.snapshot), &image, planar(back.T_from_to));
}

streetmap::DeskewedView StreetMapTracker::view(const SweepSnapshot& snapshot) const {
  const motion::DeskewedSweep& deskewed = snapshot.deskewed;
  return {snapshot.sweep, deskewed.x, deskewed.y, deskewed.z,
          rig_.lidars[snapshot.lidar].T_vehicle_lidar};
}

PoseReport StreetMapTracker::pose(const PoseReport& odometry) const {
  const streetmap::TrackerEstimate estimate = tracker_->estimate();
  PoseReport report = odometry;
  report.frame = PoseFrame::kMap;
  report.T_frame_vehicle = estimate.T_map_vehicle();
  report.covariance = estimate.pose_covariance();
  report.map = {estimate.state, estimate.p_value, estimate.entropy, estimate.reason};
  const bool usable = settings_.require_tracking
                          ? estimate.state == streetmap::TrackState::kTracking
                          : estimate.usable();
  report.reason = usable ? "" : *estimate.reason != '\0' ? estimate.reason : "lost";
  return report;
}

void StreetMapTracker::write(ViewMapPose& out) const {
  const streetmap::TrackerEstimate estimate = tracker_->estimate();
  out.T_map_vehicle = estimate.T_map_vehicle();
  out.covariance = estimate.covariance.topLeftCorner<2, 2>();
  out.particles.clear();
  if (estimate.state == streetmap::TrackState::kTracking) return;
  const std::span<const streetmap::Particle> all = tracker_->particles();
  const size_t step = (all.size() + ViewMapPose::kMaxParticles - 1) / ViewMapPose::kMaxParticles;
  for (size_t i = 0; i < all.size(); i += step) {
    out.particles.push_back({static_cast<float>(all[i].pose.x), static_cast<float>(all[i].pose.y)});
  }
}

StreetMapStatus StreetMapTracker::status() const {
  const streetmap::TrackerEstimate estimate = tracker_->estimate();
  StreetMapStatus status;
  status.state = estimate.state;
  status.reason = estimate.reason;
  status.x = estimate.pose.x;
  status.y = estimate.pose.y;
  status.sigma = kUnknownSigma;
  if (tracker_->started()) {
    status.sigma = streetmap::PoseMoments{estimate.pose, estimate.covariance}.spread();
  }
  status.elsewhere = estimate.elsewhere;
  status.places = tracker_->possible_places();
  status.gnss_offset = estimate.gnss_offset;
  status.gnss_offset_sigma = estimate.gnss_offset_sigma;
  status.p_value = estimate.p_value;
  status.entropy = estimate.entropy;
  status.particles = static_cast<uint32_t>(estimate.particles);
  status.hypotheses = static_cast<uint32_t>(estimate.hypotheses);
  status.updates = updates_;
  status.on_map = estimate.on_map;
  status.gnss_contradicts = estimate.gnss_contradicts;
  // A mismatch needs a settled null distribution, and particles that had time to agree: of a
  // vehicle that stands nothing is compared.
  const streetmap::ConfidenceOptions& confidence = settings_.tracker.confidence;
  status.mismatch = estimate.on_map && estimate.updates >= 4 * confidence.window &&
                    estimate.p_value > confidence.max_kept_p_value;
  return status;
}

}  // namespace infuse::daemon
