#include "daemon/playback/sweep_pairing.hpp"

#include <algorithm>
#include <cmath>

#include "fusion/geometry/mean_twist.hpp"

namespace infuse::daemon {
namespace {

constexpr Duration kMaxWait{1'000'000'000};   // until the next sweep and its odometry have arrived
constexpr Duration kTwistWindow{40'000'000};  // over which the twist is averaged

}  // namespace

SweepPairing::SweepPairing(const OdometrySettings& settings,
                           const Eigen::Isometry3d& T_vehicle_lidar, bool has_odometry,
                           Duration max_gap)
    : has_odometry_(has_odometry),
      max_gap_(max_gap),
      T_vehicle_lidar_(T_vehicle_lidar),
      odometry_(settings, T_vehicle_lidar),
      deskewer_(T_vehicle_lidar) {}

void SweepPairing::add_exposure(Stamp exposure) {
  exposures_.push_back(exposure);
  pairs_.emplace_back();
}

void SweepPairing::add_sweep(const Sweep& sweep) {
  if (odometry_.uses_lidar()) odometry_.add_sweep(sweep);  // else only samples are needed
  for (size_t k = next_; k < exposures_.size(); ++k) {
    const Duration gap = pairing_gap(exposures_[k], sweep);
    PairedSweep& pair = pairs_[k];
    if (gap > max_gap_ || (pair.found && gap >= pair.gap)) continue;
    pair.found = true;
    pair.gap = gap;
    pair.sweep = sweep;
  }
}

void SweepPairing::add_sample(const VehicleSample& sample) { odometry_.add_sample(sample); }

void SweepPairing::advance(Stamp now) {
  odometry_.process_due(now, [](const Sweep&, const motion::DeskewedSweep&) {});
  while (!done() && now - exposures_[next_] > kMaxWait) deskew(next_++);
}

std::vector<PairedSweep> SweepPairing::finish() {
  odometry_.finish([](const Sweep&, const motion::DeskewedSweep&) {});
  while (!done()) deskew(next_++);
  return std::move(pairs_);
}

std::optional<geometry::Vector6> SweepPairing::twist_at(Stamp exposure) const {
  const auto twist = geometry::mean_twist(odometry_.trajectory(), exposure - kTwistWindow / 2,
                                          exposure + kTwistWindow / 2);
  if (!twist) return std::nullopt;
  return geometry::adjoint(T_vehicle_lidar_.inverse()) * *twist;
}

void SweepPairing::deskew(size_t exposure) {
  PairedSweep& pair = pairs_[exposure];
  if (!pair.found) return;
  pair.twist = twist_at(exposures_[exposure]);
  deskewer_.deskew(pair.sweep, odometry_.trajectory(), exposures_[exposure], deskewed_);
  if (!deskewed_.usable()) {
    pair.deskew_reason = has_odometry_ ? deskewed_.reason : "the drive has no odometry";
    const Stamp end = pair.sweep.stamp + pair.sweep.span;
    pair.uncompensated = std::max(distance_between(exposures_[exposure], pair.sweep.stamp),
                                  distance_between(exposures_[exposure], end));
    return;
  }
  Sweep& sweep = pair.sweep;
  sweep.x.swap(deskewed_.x);
  sweep.y.swap(deskewed_.y);
  sweep.z.swap(deskewed_.z);
}

}  // namespace infuse::daemon
