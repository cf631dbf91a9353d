#include "fusion/calibration/pose_drift.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "fusion/calibration/distributions.hpp"

namespace infuse::calibration {
namespace {

using geometry::Matrix6;
using geometry::Vector6;
using Calibrations = std::span<const DatedCalibration>;

constexpr double kDoubtfulPValue = 0.1;  // one in ten by chance: covariances are in doubt

/// A change and the poses with it.
struct Candidate {
  PoseChange change;
  ChangedPose fit;
};

/// Shares of a step before calibration `first`.
std::vector<double> step_shares(size_t count, size_t first) {
  std::vector<double> shares(count, 0.0);
  std::fill(shares.begin() + static_cast<ptrdiff_t>(first), shares.end(), 1.0);
  return shares;
}

/// Shares of a ramp that begins at the date of calibration `first` − 1 and ends at the last one.
std::vector<double> ramp_shares(Calibrations calibrations, size_t first) {
  const double begin = calibrations[first - 1].days;
  const double span = calibrations.back().days - begin;
  std::vector<double> shares(calibrations.size(), 0.0);
  for (size_t i = first; span > 0 && i < shares.size(); ++i) {
    shares[i] = (calibrations[i].days - begin) / span;
  }
  return shares;
}

/// The steps and ramps of a segment. A ramp of two calibrations is a step.
std::vector<Candidate> candidates_of(Calibrations segment, const Eigen::Isometry3d& T) {
  std::vector<Candidate> candidates;
  const size_t n = segment.size();
  const auto add = [&](ChangeKind kind, size_t first, const std::vector<double>& shares) {
    ChangedPose fit = pool_changed(segment, shares, T);
    if (!fit.usable()) return;
    PoseChange change{.kind = kind, .first = first, .change = fit.change};
    change.last = kind == ChangeKind::kStep ? first : n - 1;
    candidates.push_back({change, std::move(fit)});
  };
  for (size_t first = 1; first < n; ++first) {
    add(ChangeKind::kStep, first, step_shares(n, first));
    if (first + 1 < n && segment[first].days < segment.back().days) {
      add(ChangeKind::kRamp, first, ramp_shares(segment, first));
    }
  }
  return candidates;
}

/// The probability that the best of `count` candidates decreases χ² by `gain` by chance. Where what
/// remains is more than the covariances have, these are not relied on: Fisher's distribution.
double p_value_of(double gain, const ChangedPose& fit, size_t count) {
  double p = chi_squared_exceeded(gain, 6);
  const int rest = fit.degrees_of_freedom;
  if (rest > 0 && chi_squared_exceeded(fit.chi_squared, rest) < kDoubtfulPValue) {
    p = std::max(p, fisher6_exceeded(gain / 6 / (fit.chi_squared / rest), rest));
  }
  return std::min(1.0, p * static_cast<double>(count));
}

/// Sets the change's sigma, axis and share from the poses with it.
void describe_axis(Candidate& candidate) {
  const Matrix6 covariance = candidate.fit.covariance.bottomRightCorner<6, 6>();
  const Matrix6 information = covariance.llt().solve(Matrix6::Identity());
  PoseChange& change = candidate.change;
  change.sigma = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  const Vector6 pull = information * change.change;
  const Vector6 alone = pull.cwiseAbs2().cwiseQuotient(information.diagonal());
  const double together = pull.dot(change.change);
  change.share = together > 0 ? alone.maxCoeff(&change.axis) / together : 0;
}

/// The change of a segment, its indices counted from `offset`; none if none is significant.
std::optional<PoseChange> find_change(Calibrations segment, size_t offset,
                                      const Eigen::Isometry3d& T, const PoseDriftOptions& options) {
  const PooledPose pooled = pool_calibrations(segment, T);
  if (!pooled.usable() || pooled.p_value > options.significance) return std::nullopt;
  std::vector<Candidate> candidates = candidates_of(segment, pooled.T_camera_lidar);
  const auto best = std::min_element(
      candidates.begin(), candidates.end(),
      [](const auto& a, const auto& b) { return a.fit.chi_squared < b.fit.chi_squared; });
  if (best == candidates.end()) return std::nullopt;
  PoseChange& change = best->change;
  change.p_value =
      p_value_of(pooled.chi_squared - best->fit.chi_squared, best->fit, candidates.size());
  if (change.p_value > options.significance) return std::nullopt;
  describe_axis(*best);
  change.first += offset;
  change.last += offset;
  return change;
}

/// Adds the changes from `begin` to before `end`.
void find_changes(Calibrations calibrations, size_t begin, size_t end, const Eigen::Isometry3d& T,
                  const PoseDriftOptions& options, std::vector<PoseChange>& changes) {
  if (end - begin < 2 || changes.size() >= options.max_changes) return;
  const auto change = find_change(calibrations.subspan(begin, end - begin), begin, T, options);
  if (!change) return;
  changes.push_back(*change);
  find_changes(calibrations, begin, change->first, T, options, changes);
  if (change->kind == ChangeKind::kStep) {
    find_changes(calibrations, change->first, end, T, options, changes);
  }
}

/// The pose after the last change.
PooledPose current_pose(Calibrations calibrations, const PoseChange& change, size_t before,
                        const Eigen::Isometry3d& T) {
  if (change.kind == ChangeKind::kStep) {
    return pool_calibrations(calibrations.subspan(change.first), T);
  }
  const Calibrations segment = calibrations.subspan(before);
  const ChangedPose fit = pool_changed(segment, ramp_shares(segment, change.first - before), T);
  PooledPose pose{.chi_squared = fit.chi_squared,
                  .degrees_of_freedom = fit.degrees_of_freedom,
                  .reason = fit.reason};
  if (!fit.usable()) return pose;
  pose.T_camera_lidar = geometry::exp(fit.change) * fit.T_before;
  Eigen::Matrix<double, 6, 12> by;
  by << geometry::adjoint(geometry::exp(fit.change)), geometry::left_jacobian(fit.change);
  pose.covariance = by * fit.covariance * by.transpose();
  pose.p_value = chi_squared_exceeded(pose.chi_squared, pose.degrees_of_freedom);
  return pose;
}

}  // namespace

std::optional<std::string> PoseDriftOptions::invalid() const {
  if (!(significance > 0 && significance < 0.5)) return "significance must be between 0 and 0.5";
  if (max_changes < 1 || max_changes > 1000) return "max_changes must be between 1 and 1000";
  return std::nullopt;
}

PoseHistory find_pose_drift(Calibrations calibrations, const Eigen::Isometry3d& T_reference,
                            const PoseDriftOptions& options) {
  PoseHistory history{.all = pool_calibrations(calibrations, T_reference)};
  history.current = history.all;
  history.reason = history.all.reason;
  if (calibrations.empty()) return history;
  history.verdict = PoseVerdict::kInconsistent;
  if (!history.usable()) return history;
  if (calibrations.size() == 1) {
    history.verdict = PoseVerdict::kSingle;
    return history;
  }
  find_changes(calibrations, 0, calibrations.size(), history.all.T_camera_lidar, options,
               history.changes);
  std::sort(history.changes.begin(), history.changes.end(),
            [](const PoseChange& a, const PoseChange& b) { return a.first < b.first; });
  if (!history.changes.empty()) {
    const size_t changes = history.changes.size();
    const size_t before = changes > 1 ? history.changes[changes - 2].last : 0;
    history.verdict = PoseVerdict::kDrift;
    history.current =
        current_pose(calibrations, history.changes.back(), before, history.all.T_camera_lidar);
    history.reason = history.current.reason;
  } else if (history.all.p_value > options.significance) {
    history.verdict = PoseVerdict::kOnePose;
  }
  if (history.current.degrees_of_freedom > 0) {
    history.scale = std::max(1.0, history.current.chi_squared / history.current.degrees_of_freedom);
  }
  history.current.covariance *= history.scale;
  return history;
}

}  // namespace infuse::calibration
