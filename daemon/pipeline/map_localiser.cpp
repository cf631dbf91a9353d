#include "daemon/pipeline/map_localiser.hpp"

#include <algorithm>

#include "daemon/pipeline/unknown_pose.hpp"

namespace infuse::daemon {
namespace {

constexpr size_t kMaxWaitingSweeps = 24;
/// Drive time after which results become visible: a search compares several places.
constexpr Duration kSearchBudget{1'000'000'000}, kTrackingBudget{300'000'000};

streetmap::TrackState track_state(places::LocaliserState state) {
  switch (state) {
    case places::LocaliserState::kTracking:
      return streetmap::TrackState::kTracking;
    case places::LocaliserState::kUnsure:
      return streetmap::TrackState::kUnsure;
    case places::LocaliserState::kLost:
      break;
  }
  return streetmap::TrackState::kLost;
}

}  // namespace

MapLocaliser::MapLocaliser(places::PlaceMap map, const Eigen::Isometry3d& T_vehicle_lidar,
                           bool blocking)
    : localiser_(std::move(map), T_vehicle_lidar), worker_(blocking) {
  waiting_.sweeps.resize(kMaxWaitingSweeps);
  working_.sweeps.resize(kMaxWaitingSweeps);
}

PoseReport MapLocaliser::process(const SweepSnapshot& snapshot,
                                 const geometry::Trajectory& trajectory,
                                 const PoseReport& odometry) {
  const Stamp now = snapshot.deskewed.reference;
  if (worker_.consume_result(now)) consume(result_);
  add(snapshot, trajectory);
  if (!worker_.busy() && waiting_.size > 0) start_work(now);
  return carry(trajectory, odometry);
}

void MapLocaliser::add(const SweepSnapshot& snapshot, const geometry::Trajectory& trajectory) {
  const motion::DeskewedSweep& deskewed = snapshot.deskewed;
  const Stamp now = deskewed.reference;
  if (waiting_.size == waiting_.sweeps.size()) {
    ++status_.dropped;
    return;
  }
  const geometry::MotionBetween motion = trajectory.between(last_, now);
  last_ = now;
  WaitingSweep& sweep = waiting_.sweeps[waiting_.size++];
  sweep.x = deskewed.x;
  air_.find(snapshot.sweep);
  air_.leave_out(sweep.x);
  sweep.y = deskewed.y;
  sweep.z = deskewed.z;
  sweep.reflectivity = snapshot.sweep.reflectivity;
  sweep.motion = {.stamp = now};
  // A sweep that is not deskewed would blur its place.
  sweep.motion.registered = deskewed.usable();
  sweep.motion.measured = motion.usable();
  if (!motion.usable()) return;
  sweep.motion.T_from_to = motion.T_from_to;
  sweep.motion.covariance = motion.covariance;
}

void MapLocaliser::start_work(Stamp now) {
  std::swap(waiting_, working_);
  waiting_.size = 0;
  const bool lost = pose_.state == places::LocaliserState::kLost;
  worker_.start(now, lost ? kSearchBudget : kTrackingBudget, [this](const std::stop_token& stop) {
    failure_ = "";
    for (size_t i = 0; i < working_.size && !stop.stop_requested(); ++i) {
      const WaitingSweep& sweep = working_.sweeps[i];
      const auto pose =
          localiser_.add({sweep.x, sweep.y, sweep.z}, sweep.reflectivity, sweep.motion);
      if (!pose) {
        failure_ = "a cloud of the map cannot be read";
        return;
      }
      result_ = *pose;
      result_verified_ += pose->verified ? 1 : 0;
    }
  });
}

void MapLocaliser::consume(const places::LocaliserPose& found) {
  if (found.state == places::LocaliserState::kTracking &&
      pose_.state != places::LocaliserState::kTracking) {
    ++status_.found;
  }
  pose_ = found;
  reason_ = *failure_ != '\0' ? failure_ : found.reason;
  status_.verified = result_verified_;
  status_.place = found.place;
  if (*failure_ != '\0') pose_.state = places::LocaliserState::kLost;
}

// exp(δ) T = T exp(Ad(T⁻¹) δ): covariances are converted between left and right perturbations.
PoseReport MapLocaliser::carry(const geometry::Trajectory& trajectory, const PoseReport& odometry) {
  PoseReport report = odometry;
  report.frame = PoseFrame::kMap;
  status_.state = pose_.state;
  geometry::Matrix6 covariance = geometry::Matrix6::Zero();
  if (pose_.state != places::LocaliserState::kLost) {
    const geometry::MotionBetween since = trajectory.between(pose_.stamp, odometry.stamp);
    report.T_frame_vehicle = pose_.T_map_vehicle * since.T_from_to;
    covariance = geometry::transform_covariance(since.T_from_to.inverse(),
                                                pose_.covariance + since.covariance);
    report.covariance = geometry::transform_covariance(report.T_frame_vehicle, covariance);
    status_.sigma = std::sqrt(covariance.block<3, 3>(3, 3).diagonal().maxCoeff());
    report.reason = since.usable() ? reason_ : since.reason;
  } else {
    status_.sigma = kUnknownSigma;
    report.T_frame_vehicle = Eigen::Isometry3d::Identity();
    report.covariance = kUnknownVariance * geometry::Matrix6::Identity();
    report.reason = *reason_ != '\0' ? reason_ : "lost";
  }
  status_.reason = report.reason;
  report.map = MapConfidence{
      .state = track_state(pose_.state), .p_value = {}, .entropy = {}, .reason = report.reason};
  return report;
}

MapStatus MapLocaliser::status() const { return status_; }

}  // namespace infuse::daemon
