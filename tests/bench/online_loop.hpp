#pragma once

#include <ctime>
#include <random>

#include "drivers/measurement/angles.hpp"
#include "fusion/monitoring/calibration_supervisor.hpp"
#include "tests/bench/online_drive.hpp"

/// Calibration fault during a drive, with the response of the monitor and of the decision.
namespace infuse::online {

using geometry::Vector6;

/// Step fault of the rig at a given pair.
struct Fault {
  Vector6 perturbation = Vector6::Zero();
  size_t first_pair = 0;
};

constexpr double kHalfDegree = 8.7e-3;

/// Random fault by seed: 0.5° about one of three axes or 5 cm along x or y, of either sign, at a
/// time that leaves enough of a drive of 90 s.
inline Fault random_fault(uint64_t seed, const std::vector<int>& axes, size_t latest) {
  std::mt19937_64 random(seed);
  const int axis = axes[random() % axes.size()];
  const double size = (random() % 2 == 0 ? 1 : -1) * (axis < 3 ? kHalfDegree : 0.05);
  return {size * Vector6::Unit(axis), 30 + random() % (latest - 30)};
}

/// Result of one fault.
struct RecoveryResult {
  bool applied = false;
  Vector6 error = Vector6::Zero();  ///< of the calibration in use at the end
  double normalised_error = 0;      ///< squared error per degree of freedom
  double alarm_delay = 0,
         apply_delay = 0;           ///< s: fault to confirmation, confirmation to application
  std::vector<double> cpu_seconds;  ///< s, of each re-estimation
};

/// Complete loop: step fault, alarm, re-estimation, application.
inline RecoveryResult run_recovery(const Drive& drive, const Fault& fault) {
  RecoveryResult out;
  monitoring::CalibrationMonitor monitor(drive.intrinsics, drive.T_camera_lidar, {});
  const Eigen::Isometry3d wrong = geometry::exp(fault.perturbation) * drive.T_camera_lidar;
  monitoring::CalibrationSupervisor supervisor(wrong, {.policy = monitoring::UpdatePolicy::kApply});
  std::optional<Stamp> alarm;
  for (size_t i = 0; i < drive.pairs.size(); ++i) {
    const ImageSweepPair& pair = drive.pairs[i];
    if (i == fault.first_pair) monitor.inject_miscalibration(wrong);
    const auto report = monitor.process(pair.grey, monitoring::make_sweep_view(pair.sweep),
                                        {pair.angular_rate, pair.velocity});
    if (i < fault.first_pair) continue;
    if (!alarm && report.verdict.drift == monitoring::Drift::kConfirmed) {
      alarm = pair.grey.stamp;
      out.alarm_delay = to_seconds(*alarm - drive.pairs[fault.first_pair].grey.stamp);
    }
    const auto actions = supervisor.process(report, monitor.scenes().count_since(report.since));
    if (actions.calibration_changed) {
      monitor.set_calibration(supervisor.current());
      if (!out.applied && supervisor.covariance()) {
        out.applied = true;
        out.apply_delay = to_seconds(pair.grey.stamp - alarm.value_or(pair.grey.stamp));
      }
    }
    if (actions.alternative_changed) monitor.set_alternative(supervisor.alternative());
    if (!actions.start_reestimation) continue;
    const auto scenes = monitor.scenes().lend(actions.scenes_since);
    const auto begin = std::clock();
    supervisor.finish_reestimation(
        monitoring::reestimate(scenes, drive.intrinsics, supervisor.current(), {}));
    monitor.scenes().end_lending();
    out.cpu_seconds.push_back(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
  }
  out.error = geometry::log(supervisor.current() * drive.T_camera_lidar.inverse());
  if (supervisor.covariance()) {
    out.normalised_error = out.error.dot(supervisor.covariance()->inverse() * out.error) / 6;
  }
  return out;
}

/// What a drift that begins at a pair looks like, 10 s after its confirmation or at the end.
struct KnockResult {
  double suspected = 1e9, confirmed = 1e9;  ///< s after it began
  monitoring::DriftVerdict verdict;
};

/// Runs the monitor on a drive that knocks the rig, or whose stamps become late by `delay`, s.
inline KnockResult run_knock(const Drive& drive, const Fault& fault, double delay = 0) {
  constexpr double kReportedAfter = 10;  // s
  KnockResult out;
  monitoring::CalibrationMonitor monitor(drive.intrinsics, drive.T_camera_lidar, {});
  const Stamp begin = drive.pairs[fault.first_pair].grey.stamp;
  for (size_t i = 0; i < drive.pairs.size(); ++i) {
    const ImageSweepPair& pair = drive.pairs[i];
    if (i >= fault.first_pair) {
      Vector6 twist;
      twist << pair.angular_rate, pair.velocity;
      // A late camera sees the world from where it was: returns are farther on than they should.
      monitor.inject_miscalibration(geometry::exp(-delay * twist) *
                                    geometry::exp(fault.perturbation) * drive.T_camera_lidar);
    }
    const auto report = monitor.process(pair.grey, monitoring::make_sweep_view(pair.sweep),
                                        {pair.angular_rate, pair.velocity});
    if (i < fault.first_pair) continue;
    const double after = to_seconds(pair.grey.stamp - begin);
    out.verdict = report.verdict;
    if (report.verdict.drifting()) out.suspected = std::min(out.suspected, after);
    if (report.verdict.drift == monitoring::Drift::kConfirmed) {
      out.confirmed = std::min(out.confirmed, after);
    }
    if (after >= out.confirmed + kReportedAfter) break;
  }
  return out;
}

/// Accumulated degrees of a slow drift about one axis when it was suspected and when it was
/// confirmed; 1e9 if never.
struct DriftAngles {
  double suspected_deg = 1e9, confirmed_deg = 1e9;
};

/// Runs consecutive drives while the rig turns at a constant rate in degrees per minute.
inline DriftAngles detect_slow_drift(const std::vector<const Drive*>& drives, int axis,
                                     double degrees_per_minute) {
  DriftAngles out;
  const Truth& rig = *drives.front();
  monitoring::CalibrationMonitor monitor(rig.intrinsics, rig.T_camera_lidar, {});
  Duration before{0};
  for (const Drive* drive : drives) {
    if (drive->pairs.empty()) continue;
    const Stamp first = drive->pairs.front().grey.stamp;
    CameraFrame grey;
    Duration last{0};
    for (const ImageSweepPair& pair : drive->pairs) {
      last = pair.grey.stamp - first;
      grey = pair.grey;
      grey.stamp = drives.front()->pairs.front().grey.stamp + before + last;
      const double degrees = degrees_per_minute * to_seconds(before + last) / 60;
      monitor.inject_miscalibration(geometry::exp(degrees * kDegree * Vector6::Unit(axis)) *
                                    drive->T_camera_lidar);
      const auto report = monitor.process(grey, monitoring::make_sweep_view(pair.sweep),
                                          {pair.angular_rate, pair.velocity});
      if (report.verdict.drift == monitoring::Drift::kSuspected &&
          report.verdict.axis == static_cast<monitoring::Axis>(axis)) {
        out.suspected_deg = std::min(out.suspected_deg, std::abs(degrees));
      }
      if (report.verdict.drift == monitoring::Drift::kConfirmed) {
        out.confirmed_deg = std::abs(degrees);
        out.suspected_deg = std::min(out.suspected_deg, out.confirmed_deg);
        return out;
      }
    }
    before += last + Duration(500'000'000);
  }
  return out;
}

}  // namespace infuse::online
