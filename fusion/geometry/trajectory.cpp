#include "fusion/geometry/trajectory.hpp"

#include <cmath>

#include "fusion/geometry/symmetric_eigen.hpp"

namespace infuse::geometry {
namespace {

constexpr const char* kReasonEmpty = "the trajectory is empty";
constexpr const char* kReasonBeforeFirst = "the time is before the first pose";
constexpr const char* kReasonAfterLast = "the time is after the last pose";
constexpr const char* kReasonGap = "the poses around the time are too far apart";

/// Nearest positive semidefinite matrix. A difference of two covariances may be indefinite, by
/// rounding or by information gained in between.
Matrix6 positive_part(const Matrix6& symmetric) {
  const auto eigen = symmetric_eigen<6>(0.5 * (symmetric + symmetric.transpose()));
  return eigen.vectors * eigen.values.cwiseMax(0).asDiagonal() * eigen.vectors.transpose();
}

}  // namespace

MotionBetween motion_between(const PoseAt& from, const PoseAt& to, bool backwards) {
  MotionBetween motion;
  const Eigen::Isometry3d T_from_odom = from.T_odom_vehicle.inverse();
  motion.T_from_to = T_from_odom * to.T_odom_vehicle;
  const double sign = backwards ? -1 : 1;
  const Matrix6 steps = sign * (to.steps - from.steps);
  const Matrix6 growth = sign * (to.covariance - from.covariance);
  motion.covariance = transform_covariance(T_from_odom, steps) +
                      positive_part(transform_covariance(T_from_odom, growth - steps));
  return motion;
}

std::optional<std::string> TrajectoryOptions::invalid() const {
  if (capacity < 2) return "capacity must be at least 2 poses";
  if (max_gap <= Duration::zero()) return "max_gap must be positive";
  if (max_extrapolation < Duration::zero()) return "max_extrapolation must not be negative";
  if (!(rotation_growth >= 0) || !(translation_growth >= 0)) return "growth must not be negative";
  return std::nullopt;
}

Trajectory::Trajectory(const TrajectoryOptions& options)
    : options_(options), ring_(options.capacity) {}

bool Trajectory::append(const StampedPose& pose) {
  if (size_ > 0 && pose.stamp <= (*this)[size_ - 1].stamp) return false;
  ring_[(first_ + size_) % ring_.size()] = pose;
  if (size_ < ring_.size()) {
    ++size_;
  } else {
    first_ = (first_ + 1) % ring_.size();
  }
  return true;
}

void Trajectory::correct(size_t index, const StampedPose& pose) {
  ring_[(first_ + index) % ring_.size()] = pose;
}

void Trajectory::clear() { first_ = size_ = 0; }

const StampedPose& Trajectory::operator[](size_t index) const {
  return ring_[(first_ + index) % ring_.size()];
}

size_t Trajectory::index_at_or_after(Stamp stamp) const {
  size_t low = 0, high = size_;
  while (low < high) {
    const size_t middle = low + (high - low) / 2;
    if ((*this)[middle].stamp < stamp) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

PoseAt Trajectory::at(Stamp stamp) const {
  if (size_ == 0) return {.reason = kReasonEmpty};
  const size_t after = index_at_or_after(stamp);
  if (after == size_) return extrapolate(stamp);
  const StampedPose& b = (*this)[after];
  if (b.stamp == stamp) return {b.T_odom_vehicle, b.covariance, b.steps, ""};
  if (after == 0) return {.reason = kReasonBeforeFirst};
  const StampedPose& a = (*this)[after - 1];
  if (b.stamp - a.stamp > options_.max_gap) return {.reason = kReasonGap};
  const double u = to_seconds(stamp - a.stamp) / to_seconds(b.stamp - a.stamp);
  return {interpolate(a.T_odom_vehicle, b.T_odom_vehicle, u),
          (1 - u) * a.covariance + u * b.covariance, (1 - u) * a.steps + u * b.steps, ""};
}

PoseAt Trajectory::extrapolate(Stamp stamp) const {
  const StampedPose& last = (*this)[size_ - 1];
  if (size_ < 2 || stamp - last.stamp > options_.max_extrapolation)
    return {.reason = kReasonAfterLast};
  const StampedPose& previous = (*this)[size_ - 2];
  if (last.stamp - previous.stamp > options_.max_gap) return {.reason = kReasonAfterLast};
  const double ahead = to_seconds(stamp - last.stamp);
  const double u = 1 + ahead / to_seconds(last.stamp - previous.stamp);
  Vector6 growth;
  growth << Eigen::Vector3d::Constant(std::pow(options_.rotation_growth, 2) * ahead),
      Eigen::Vector3d::Constant(std::pow(options_.translation_growth, 2) * ahead);
  PoseAt result;
  result.T_odom_vehicle = interpolate(previous.T_odom_vehicle, last.T_odom_vehicle, u);
  result.steps = last.steps;
  result.covariance =
      last.covariance + transform_covariance(result.T_odom_vehicle, growth.asDiagonal());
  return result;
}

MotionBetween Trajectory::between(Stamp from, Stamp to) const {
  const PoseAt a = at(from), b = at(to);
  MotionBetween motion;
  motion.reason = !a.usable()   ? a.reason
                  : !b.usable() ? b.reason
                                : uncovered_reason(std::min(from, to), std::max(from, to));
  if (!motion.usable()) return motion;
  return motion_between(a, b, to < from);
}

const char* Trajectory::uncovered_reason(Stamp from, Stamp to) const {
  if (size_ == 0) return kReasonEmpty;
  if (from < (*this)[0].stamp) return kReasonBeforeFirst;
  if (const PoseAt end = at(to); !end.usable()) return end.reason;
  for (size_t i = index_at_or_after(from); i < size_; ++i) {
    if (i > 0 && (*this)[i].stamp > from &&
        (*this)[i].stamp - (*this)[i - 1].stamp > options_.max_gap) {
      return kReasonGap;
    }
    if ((*this)[i].stamp >= to) break;
  }
  return "";
}

}  // namespace infuse::geometry
