#pragma once

#include <ctime>
#include <random>

#include "fusion/watch/decision.hpp"
#include "tests/bench/online_drive.hpp"

/// A calibration that becomes wrong during a drive, and what the watch and the decision make of it.
namespace infuse::online {

using geometry::Vector6;

/// A fault of the rig, from a pair on.
struct Fault {
  Vector6 off = Vector6::Zero();
  size_t from = 0;
};

constexpr double kHalfDegree = 8.7e-3;

/// By seed: 0.5° about one of three axes or 5 cm along x or y, of either sign, at any moment that
/// leaves enough of a drive of 90 s.
inline Fault fault_of(uint64_t seed, const std::vector<int>& axes, size_t latest) {
  std::mt19937_64 random(seed);
  const int axis = axes[random() % axes.size()];
  const double size = (random() % 2 == 0 ? 1 : -1) * (axis < 3 ? kHalfDegree : 0.05);
  return {size * Vector6::Unit(axis), 30 + random() % (latest - 30)};
}

/// What came of one fault.
struct Mended {
  bool applied = false;
  Vector6 error = Vector6::Zero();  ///< of what is in use at the end
  double normalised = 0;            ///< squared error, a degree of freedom
  double alarm = 0, after = 0;      ///< s: fault to certainty, certainty to use
  std::vector<double> cpu;          ///< s, of each re-estimation
};

/// The whole loop: a step of the rig, alarm, re-estimation, applied.
inline Mended mend(const Drive& drive, const Fault& fault) {
  Mended out;
  watch::Watch watch(drive.intrinsics, drive.T_camera_lidar, {});
  const Eigen::Isometry3d wrong = geometry::exp(fault.off) * drive.T_camera_lidar;
  watch::Decision decision(wrong, {.policy = watch::Policy::kApply});
  std::vector<watch::StoredScene> scenes;
  std::optional<Stamp> alarm;
  for (size_t i = 0; i < drive.pairs.size(); ++i) {
    const Pair& pair = drive.pairs[i];
    if (i == fault.from) watch.misplace(wrong);
    const auto report =
        watch.take(pair.grey, watch::view_of(pair.sweep), {pair.angular_rate, pair.velocity});
    if (i < fault.from) continue;
    if (!alarm && report.drift == watch::Drift::kDrifted) {
      alarm = pair.grey.stamp;
      out.alarm = to_seconds(*alarm - drive.pairs[fault.from].grey.stamp);
    }
    const auto decided = decision.take(report, watch.scenes().count_since(report.since));
    if (decided.calibration_changed) {
      watch.set_calibration(decision.present());
      if (!out.applied && decision.covariance()) {
        out.applied = true;
        out.after = to_seconds(pair.grey.stamp - alarm.value_or(pair.grey.stamp));
      }
    }
    if (decided.alternative_changed) watch.set_alternative(decision.alternative());
    if (!decided.start) continue;
    watch.scenes().copy(decided.since, scenes);
    const auto begin = std::clock();
    decision.finish(watch::reestimate(scenes, drive.intrinsics, decision.present(), {}));
    out.cpu.push_back(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
  }
  out.error = geometry::log(decision.present() * drive.T_camera_lidar.inverse());
  if (decision.covariance()) {
    out.normalised = out.error.dot(decision.covariance()->inverse() * out.error) / 6;
  }
  return out;
}

/// Degrees built up when a slow drift about one axis was suspected and when it was certain; 1e9
/// where it never was.
struct Noticed {
  double suspect = 1e9, certain = 1e9;
};

/// Drives one drive after the other while the rig turns by so many degrees a minute.
inline Noticed notice_slow(const std::vector<const Drive*>& drives, int axis,
                           double degrees_a_minute) {
  Noticed out;
  const Truth& rig = *drives.front();
  watch::Watch watch(rig.intrinsics, rig.T_camera_lidar, {});
  Duration before{0};
  for (const Drive* drive : drives) {
    if (drive->pairs.empty()) continue;
    const Stamp first = drive->pairs.front().grey.stamp;
    CameraFrame grey;
    Duration last{0};
    for (const Pair& pair : drive->pairs) {
      last = pair.grey.stamp - first;
      grey = pair.grey;
      grey.stamp = drives.front()->pairs.front().grey.stamp + before + last;
      const double degrees = degrees_a_minute * to_seconds(before + last) / 60;
      watch.misplace(geometry::exp(degrees * M_PI / 180 * Vector6::Unit(axis)) *
                     drive->T_camera_lidar);
      const auto report =
          watch.take(grey, watch::view_of(pair.sweep), {pair.angular_rate, pair.velocity});
      if (report.drift == watch::Drift::kSuspect && report.axis == static_cast<watch::Axis>(axis)) {
        out.suspect = std::min(out.suspect, std::abs(degrees));
      }
      if (report.drift == watch::Drift::kDrifted) {
        out.certain = std::abs(degrees);
        out.suspect = std::min(out.suspect, out.certain);
        return out;
      }
    }
    before += last + Duration(500'000'000);
  }
  return out;
}

}  // namespace infuse::online
