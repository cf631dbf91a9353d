#include "daemon/commands/sweep_pairing.hpp"

#include <cmath>

namespace infuse::daemon {
namespace {

constexpr Duration kWait{1'000'000'000};  // until the next sweep and its odometry have come
constexpr Duration kMoment{40'000'000};   // over which a speed is taken

Stamp middle(const Sweep& sweep) { return sweep.stamp + sweep.span / 2; }

}  // namespace

SweepPairing::SweepPairing(const Eigen::Isometry3d& T_vehicle_lidar, bool has_odometry)
    : has_odometry_(has_odometry),
      T_vehicle_lidar_(T_vehicle_lidar),
      compensator_(T_vehicle_lidar) {}

void SweepPairing::want(Stamp exposure) {
  exposures_.push_back(exposure);
  pairs_.emplace_back();
}

void SweepPairing::take(const Sweep& sweep) {
  for (size_t k = next_; k < exposures_.size(); ++k) {
    const Duration gap = distance_between(middle(sweep), exposures_[k]);
    PairedSweep& pair = pairs_[k];
    if (pair.found ? gap >= pair.gap : gap > kWait) continue;
    pair.found = true;
    pair.gap = gap;
    pair.sweep = sweep;
  }
}

void SweepPairing::take(const VehicleSample& sample) { odometry_.take(sample); }

void SweepPairing::advance(Stamp now) {
  while (!done() && now - exposures_[next_] > kWait) straighten(next_++);
}

std::vector<PairedSweep> SweepPairing::finish() {
  odometry_.finish();
  while (!done()) straighten(next_++);
  return std::move(pairs_);
}

std::optional<geometry::Vector6> SweepPairing::twist_at(Stamp exposure) const {
  const geometry::MotionBetween motion =
      odometry_.trajectory().between(exposure - kMoment / 2, exposure + kMoment / 2);
  if (!motion.usable()) return std::nullopt;
  const Eigen::Isometry3d lidar = T_vehicle_lidar_.inverse() * motion.T_from_to * T_vehicle_lidar_;
  return geometry::log(lidar) / to_seconds(kMoment);
}

void SweepPairing::straighten(size_t exposure) {
  PairedSweep& pair = pairs_[exposure];
  if (!pair.found) return;
  if (!has_odometry_) {
    pair.uncompensated = "the drive has no odometry";
    return;
  }
  compensator_.compensate(pair.sweep, odometry_.trajectory(), exposures_[exposure], straight_);
  if (!straight_.usable()) {
    pair.uncompensated = straight_.reason;
    return;
  }
  Sweep& sweep = pair.sweep;
  sweep.x.swap(straight_.x);
  sweep.y.swap(straight_.y);
  sweep.z.swap(straight_.z);
  pair.twist = twist_at(exposures_[exposure]);
}

}  // namespace infuse::daemon
