#include "fusion/monitoring/drift_search.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <span>

#include "drivers/measurement/angles.hpp"

namespace infuse::monitoring {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

constexpr size_t kReturns = 2000;  // of a scene; more cost more and say little more (decision 17)
constexpr double kBlur = 3;  // samples, of the blurred image: 0.6° of 300 samples (decision 17)
constexpr int kThin = 2;     // samples (decision 17)
// A blurred peak is as wide as two steps of the screen. About the optical axis, returns move half
// as much as at the image's border.
constexpr double kScreenStep = 1 * kDegree;
constexpr double kScreenRollStep = 2 * kDegree;
constexpr double kReach = 8 * kDegree;
constexpr double kApart = 2 * kDegree;          // poses of one peak are nearer
constexpr double kRotationSigma = 3 * kDegree;  // standard deviation of a knock
constexpr double kStep = 6e-3;  // rad, of the curvature: half a peak's width (decision 17)
constexpr double kTranslationStep = 0.04;  // m (decision 17)
constexpr double kMinEigenvalue = 0.02;  // of a correlation: 7 deviations of its axes (decision 17)
constexpr std::array<double, 6> kDelays = {0.02, 0.04, 0.06, 0.1, 0.15, 0.2};  // s (decision 17)
// s; derived from `kTranslationStep`: 3 ms are 3 cm at 10 m/s.
constexpr std::array<double, 3> kDelaySteps = {0.012, 0.006, 0.003};

Vector6 unit(int axis) { return Vector6::Unit(axis); }

Vector6 prior_sigma() {
  Vector6 sigma;
  sigma << Eigen::Vector3d::Constant(kRotationSigma), Eigen::Vector3d::Constant(kKnockSigma);
  return sigma;
}

double angle_of(const Vector6& moved) { return moved.head<3>().norm(); }

}  // namespace

Axis DriftEstimate::likeliest() const {
  return static_cast<Axis>(std::max_element(gain.begin(), gain.end()) - gain.begin());
}

void DriftSearch::add(const ComparedPlanes& planes, const ComparedReturns& returns,
                      const Motion& motion) {
  Scene& scene = scenes_[next_++ % kScenes];
  scene.fine = planes;
  scene.returns.thin(returns, kReturns);
  scene.motion = motion;
}

double DriftSearch::value_at(const Vector6& moved, Detail detail) {
  if (stop_.stop_requested()) return 0;
  const Eigen::Isometry3d T = geometry::exp(moved) * T_camera_lidar_;
  double sum = 0;
  for (size_t k = 0; k < count_; ++k) {
    const Scene& scene = recent(k);
    sum += dependence_.evaluate(T, detail == Detail::kBlurred ? scene.blurred : scene.fine,
                                scene.returns, *camera_, MonitorDependence::Outside::kNothing);
  }
  return sum / noise_ - 0.5 * moved.cwiseQuotient(prior_sigma()).squaredNorm();
}

double DriftSearch::value_late(double delay) {
  if (stop_.stop_requested()) return 0;
  double sum = 0;
  for (size_t k = 0; k < count_; ++k) {
    const Scene& scene = recent(k);
    Vector6 twist;
    twist << scene.motion.angular_rate, scene.motion.velocity;
    sum += dependence_.evaluate(geometry::exp(delay * twist) * T_camera_lidar_, scene.fine,
                                scene.returns, *camera_, MonitorDependence::Outside::kNothing);
  }
  return sum / noise_;
}

/// Keeps the best of a peak, and the best peaks.
void DriftSearch::keep_if_better(const Candidate& candidate) {
  for (size_t k = 0; k < candidate_count_; ++k) {
    if (angle_of(candidates_[k].moved - candidate.moved) > kApart) continue;
    if (candidate.nats > candidates_[k].nats) candidates_[k] = candidate;
    return;
  }
  if (candidate_count_ < kCandidates) {
    candidates_[candidate_count_++] = candidate;
    return;
  }
  Candidate& worst =
      *std::min_element(candidates_.begin(), candidates_.end(),
                        [](const Candidate& a, const Candidate& b) { return a.nats < b.nats; });
  if (candidate.nats > worst.nats) worst = candidate;
}

/// Without a known pose, all rotations in reach.
void DriftSearch::collect_candidates(const std::optional<Vector6>& known) {
  candidates_ = {};
  candidate_count_ = 1;  // the present calibration
  if (known) {
    candidates_[candidate_count_++].moved = *known;
    return;
  }
  for (size_t k = 0; k < count_; ++k) {
    Scene& scene = scenes_[(next_ - 1 - k) % kScenes];
    blur_.compute(scene.fine, kBlur, kThin, scene.blurred);
  }
  candidates_[0].nats = value_at(candidates_[0].moved, Detail::kBlurred);
  const int steps = static_cast<int>(kReach / kScreenStep);
  const int roll_steps = static_cast<int>(kReach / kScreenRollStep);
  for (int x = -steps; x <= steps; ++x) {
    for (int y = -steps; y <= steps; ++y) {
      for (int z = -roll_steps; z <= roll_steps; ++z) {
        Candidate here;
        here.moved.head<3>() << x * kScreenStep, y * kScreenStep, z * kScreenRollStep;
        if (angle_of(here.moved) > kReach) continue;
        here.nats = value_at(here.moved, Detail::kBlurred);
        keep_if_better(here);
      }
    }
  }
}

/// Sorts the candidates by their best rotations and returns the first with its best translation.
DriftSearch::Candidate DriftSearch::refine_best(bool known) {
  const std::span<Candidate> all(candidates_.data(), candidate_count_);
  for (Candidate& candidate : all) {
    if (known) {
      candidate.nats = value_at(candidate.moved, Detail::kFine);
      continue;
    }
    climb(candidate, Detail::kBlurred, kScreenStep, 0);
    for (const double step : {kScreenStep, kScreenStep / 2})
      climb(candidate, Detail::kFine, step, 0);
  }
  std::sort(all.begin(), all.end(),
            [](const Candidate& a, const Candidate& b) { return a.nats > b.nats; });
  Candidate best = all[0];
  for (int pass = 0; pass < (known ? 2 : 3); ++pass) {
    climb(best, Detail::kFine, kStep, kTranslationStep);
  }
  return best;
}

/// Moves to the maximum of the parabola along one axis after the other, by a step at most.
void DriftSearch::climb(Candidate& candidate, Detail detail, double rotation, double translation) {
  candidate.nats = value_at(candidate.moved, detail);
  for (int axis = 0; axis < (translation > 0 ? 6 : 3); ++axis) {
    const double step = axis < 3 ? rotation : translation;
    const double below = value_at(candidate.moved - step * unit(axis), detail);
    const double above = value_at(candidate.moved + step * unit(axis), detail);
    const double curvature = 2 * candidate.nats - above - below;
    const double slope = 0.5 * (above - below);
    const double part = curvature > std::abs(slope) ? slope / curvature : std::copysign(1.0, slope);
    const Vector6 there = candidate.moved + part * step * unit(axis);
    const double nats = value_at(there, detail);
    if (!(nats > candidate.nats)) continue;
    candidate.moved = there;
    candidate.nats = nats;
  }
}

/// A displacement alone may be better than the rotation that looks alike.
void DriftSearch::try_translations(Candidate& best) {
  Candidate alone{.nats = value_at(Vector6::Zero(), Detail::kFine)};
  for (int axis = 3; axis < 6; ++axis) {
    for (const double size : {0.5, -0.5, 1.0, -1.0, 2.0, -2.0}) {
      const Vector6 moved = size * kKnockSigma * unit(axis);
      const double nats = value_at(moved, Detail::kFine);
      if (nats > alone.nats) alone = {moved, nats};
    }
  }
  if (alone.moved.isZero()) return;
  for (int pass = 0; pass < 2; ++pass) climb(alone, Detail::kFine, kStep, kTranslationStep);
  if (alone.nats > best.nats) best = alone;
}

DriftSearch::Parabola DriftSearch::parabola_at(const Vector6& moved) {
  const auto offset = [](int axis) {
    return Vector6((axis < 3 ? kStep : kTranslationStep) * unit(axis));
  };
  const auto value = [&](const Vector6& by) { return value_at(moved + by, Detail::kFine); };
  Matrix6 information = Matrix6::Zero();
  const double centre = value(Vector6::Zero());
  Vector6 both, slope;  // sides of an axis
  for (int i = 0; i < 6; ++i) {
    const double above = value(offset(i)), below = value(-offset(i));
    both(i) = above + below;
    slope(i) = (above - below) / (2 * offset(i).norm());
    // The prior alone says as much.
    const double least = 1 / (prior_sigma()(i) * prior_sigma()(i));
    information(i, i) = std::max((2 * centre - both(i)) / offset(i).squaredNorm(), least);
  }
  const Vector6 scale = information.diagonal().cwiseSqrt().cwiseInverse();
  Matrix6 correlation = Matrix6::Identity();
  for (int i = 0; i < 6; ++i) {
    for (int j = i + 1; j < 6; ++j) {
      const double same = value(offset(i) + offset(j)) + value(-offset(i) - offset(j));
      const double product = offset(i).norm() * offset(j).norm();
      correlation(i, j) = correlation(j, i) =
          (both(i) + both(j) - 2 * centre - same) / (2 * product) * scale(i) * scale(j);
    }
  }
  // Differences of noisy values need not be those of a maximum.
  const Eigen::SelfAdjointEigenSolver<Matrix6> axes(correlation);
  const Matrix6 definite = axes.eigenvectors() *
                           axes.eigenvalues().cwiseMax(kMinEigenvalue).asDiagonal() *
                           axes.eigenvectors().transpose();
  return {scale.cwiseInverse().asDiagonal() * definite * scale.cwiseInverse().asDiagonal(), slope};
}

/// A rotation and the displacement that looks alike form a ridge, along which steps of one axis get
/// nowhere. Moves by Newton steps while that is better, and returns the information there.
Matrix6 DriftSearch::climb_ridge(Candidate& best) {
  constexpr int kMaxMoves = 3;     // decision 17
  constexpr double kMaxSteps = 3;  // of the parabola's (decision 17)
  Vector6 steps;
  steps << Eigen::Vector3d::Constant(kStep), Eigen::Vector3d::Constant(kTranslationStep);
  for (int move = 0;; ++move) {
    const Parabola around = parabola_at(best.moved);
    if (move == kMaxMoves) return around.information;
    Vector6 by = around.information.ldlt().solve(around.slope);
    by /= std::max(1.0, by.cwiseQuotient(steps).cwiseAbs().maxCoeff() / kMaxSteps);
    const Candidate there{best.moved + by, value_at(best.moved + by, Detail::kFine)};
    constexpr double kGain = 0.1;  // nats; less is not worth a move (decision 17)
    if (!(there.nats > best.nats + kGain)) return around.information;
    best = there;
  }
}

/// Gains by one axis alone. The best place along an axis is that nearest to the best pose.
void DriftSearch::compare_axes(const Vector6& moved, const Matrix6& information,
                               DriftEstimate& estimate) {
  const double present = value_at(Vector6::Zero(), Detail::kFine);
  for (int k = 0; k < 6; ++k) {
    const double along = information.row(k).dot(moved) / information(k, k);
    estimate.gain[static_cast<size_t>(k)] = std::max(value_at(along * unit(k), Detail::kFine),
                                                     value_at(moved(k) * unit(k), Detail::kFine)) -
                                            present;
  }
  double& late = estimate.gain[static_cast<size_t>(Axis::kTime)];
  const auto try_delay = [&](double delay) {
    const double gain = value_late(delay) - present;
    if (gain <= late) return;
    late = gain;
    estimate.delay = delay;
  };
  for (const double size : kDelays) {
    for (const double delay : {size, -size}) try_delay(delay);
  }
  // Between them, as finely as the axes are climbed.
  for (const double step : kDelaySteps) {
    const double best = estimate.delay;
    for (const double delay : {best - step, best + step}) try_delay(delay);
  }
}

DriftEstimate DriftSearch::find(const Eigen::Isometry3d& T_camera_lidar,
                                const std::optional<Vector6>& known, size_t scenes, double noise,
                                const geometry::CameraModel& camera, const std::stop_token& stop) {
  T_camera_lidar_ = T_camera_lidar;
  stop_ = stop;
  camera_ = &camera;
  count_ = std::min(scenes, kScenes);
  noise_ = noise;
  collect_candidates(known);
  Candidate best = refine_best(known.has_value());
  try_translations(best);
  const Matrix6 information = climb_ridge(best);
  DriftEstimate estimate{.moved = best.moved,
                         .at_least = angle_of(best.moved) > kReach - 0.5 * kScreenStep};
  estimate.covariance = information.inverse();
  compare_axes(best.moved, information, estimate);
  // Another peak may be the right one: the spread of both.
  const std::span<const Candidate> all(candidates_.data(), candidate_count_);
  for (const Candidate& other : all) {
    const Vector6 apart = other.moved - all[0].moved;
    if (angle_of(apart) < kApart) continue;
    const double odds = std::exp(other.nats - all[0].nats);
    estimate.covariance += odds / (1 + odds) * apart * apart.transpose();
    break;
  }
  return estimate;
}

}  // namespace infuse::monitoring
