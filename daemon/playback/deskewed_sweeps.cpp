#include "daemon/playback/deskewed_sweeps.hpp"

#include <utility>

namespace infuse::daemon {

DeskewedSweeps::DeskewedSweeps(const OdometrySettings& settings,
                               const Eigen::Isometry3d& T_vehicle_lidar, Reference reference)
    : odometry_(settings, T_vehicle_lidar),
      max_wait_(settings.max_wait),
      deskewer_(T_vehicle_lidar),
      reference_(std::move(reference)) {
  if (odometry_.uses_lidar()) lidar_motion_.emplace(T_vehicle_lidar);
}

void DeskewedSweeps::add_sweep(const Sweep& sweep) {
  odometry_.mark(end_of(sweep), lidar_motion_.has_value());
  waiting_.push_back(sweep);
}

bool DeskewedSweeps::is_due(const Sweep& sweep, Stamp now) const {
  const Stamp end = end_of(sweep);
  return now - end >= max_wait_ ||
         *odometry_.trajectory().uncovered_reason(sweep.stamp, end) == '\0';
}

void DeskewedSweeps::process(const Sweep& sweep) {
  const auto deskew = [&](Stamp reference) {
    deskewer_.deskew(sweep, odometry_.trajectory(), reference, deskewed_);
  };
  const Stamp end = end_of(sweep), reference = reference_(sweep);
  odometry_.process_until(end);
  if (lidar_motion_) {
    deskew(end);
    registered_ =
        lidar_motion_->measure(sweep, odometry_, deskewer_, deskewed_, [&] { deskew(end); });
    if (reference == end) return;
  }
  deskew(reference);
}

}  // namespace infuse::daemon
