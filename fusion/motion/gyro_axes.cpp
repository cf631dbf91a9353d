#include "fusion/motion/gyro_axes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace infuse::motion {
namespace {

constexpr size_t kKeptReadings = 512;          // bounds memory: 2.5 s at 200 Hz
constexpr double kMinReadings = 5;             // of an interval (decision 17)
constexpr Duration kMaxInterval{500'000'000};  // decision 17
constexpr double kMinVariance = 1e-12;         // rad²/s²: the readings are rounded
constexpr double kMaxRotationSigma = 0.005;    // rad; worse lidars are no reference (decision 17)

/// True if registration determines the rotation.
bool rotation_is_known(const RelativePose& motion) {
  for (int i = 0; i < 3; ++i) {
    if (!(motion.information(i, i) > 1 / (kMaxRotationSigma * kMaxRotationSigma))) return false;
  }
  return true;
}

}  // namespace

std::optional<std::string> GyroAxesOptions::invalid() const {
  if (memory <= Duration(0)) return "memory must be above 0 s";
  if (!(min_intervals >= 3)) return "min_intervals must be at least 3";
  if (!(min_lead > 0)) return "min_lead must be above 0";
  if (!(max_unexplained > 0 && max_unexplained < 1)) {
    return "max_unexplained must be between 0 and 1";
  }
  if (!(max_scale_error > 0 && max_scale_error < 1)) {
    return "max_scale_error must be between 0 and 1";
  }
  if (!(max_missing >= 0 && max_missing < 1)) return "max_missing must be between 0 and 1";
  return std::nullopt;
}

GyroAxes::GyroAxes(const Eigen::Matrix3d& R_vehicle_lidar, const GyroAxesOptions& options)
    : R_vehicle_lidar_(R_vehicle_lidar), options_(options) {
  readings_.reserve(kKeptReadings);
}

void GyroAxes::add(const GyroReadings& readings) {
  if (readings_.size() < kKeptReadings) {
    readings_.push_back(readings);
    return;
  }
  readings_[next_] = readings;
  next_ = (next_ + 1) % kKeptReadings;
}

bool GyroAxes::mean_readings(Stamp from, Stamp to, Eigen::Vector3d& mean, Eigen::Vector3d& scatter,
                             double& count) const {
  Eigen::Array3d sum = Eigen::Array3d::Zero(), squares = Eigen::Array3d::Zero();
  count = 0;
  for (const GyroReadings& r : readings_) {
    if (r.stamp <= from || r.stamp > to) continue;
    const Eigen::Array3d rate(r.rate[0], r.rate[1], r.rate[2]);
    if (!rate.allFinite()) continue;
    sum += rate;
    squares += rate.square();
    ++count;
  }
  if (count < kMinReadings) return false;
  mean = sum / count;
  scatter = ((squares - sum.square() / count) / (count - 1)).max(0.0);
  return true;
}

void GyroAxes::add(const RelativePose& motion) {
  const Duration length = motion.to - motion.from;
  if (length <= Duration(0) || length > kMaxInterval || !rotation_is_known(motion)) return;
  Eigen::Vector3d readings, scatter;
  double count = 0;
  if (!mean_readings(motion.from, motion.to, readings, scatter, count)) return;
  Vector now;
  now.head<3>() = R_vehicle_lidar_.transpose() * geometry::rotation_log(motion.T_from_to.linear()) /
                  to_seconds(length);
  now.tail<3>() = readings;
  const double since = last_ == Stamp::earliest() ? 0 : to_seconds(motion.to - last_);
  const double kept = since >= 0 ? std::exp(-since / to_seconds(options_.memory)) : 0;
  last_ = motion.to;
  weight_ = kept * weight_ + 1;
  const Vector off = now - mean_;
  mean_ += off / weight_;
  scatter_ = kept * scatter_ + off * (now - mean_).transpose();
  within_ += (scatter - within_) / weight_;
  per_interval_ += (count - per_interval_) / weight_;
  for (int gyro = 0; gyro < 3; ++gyro) {
    // A known axis stays while nothing contradicts it: a vehicle that stands says nothing.
    GyroAxis& known = axes_[static_cast<size_t>(gyro)];
    if (!known.known() || contradicted(gyro, known)) known = judge(gyro);
  }
  for (size_t a = 0; a < 3; ++a) {
    for (size_t b = a + 1; b < 3; ++b) {
      if (!axes_[a].known() || !axes_[b].known() || axes_[a].axis != axes_[b].axis) continue;
      axes_[a] = axes_[b] = GyroAxis{.reason = "two gyros seem to measure the same axis"};
    }
  }
}

/// Variance of a gyro's readings that a signed axis leaves.
double GyroAxes::unexplained(int gyro, int axis, double sign) const {
  const int row = 3 + gyro;
  const double left = scatter_(row, row) + scatter_(axis, axis) - 2 * sign * scatter_(row, axis);
  return std::max(left / weight_, kMinVariance);
}

bool GyroAxes::contradicted(int gyro, const GyroAxis& known) const {
  double best = scatter_(3 + gyro, 3 + gyro) / weight_;  // it measures nothing
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) best = std::min(best, unexplained(gyro, axis, sign));
  }
  const double left = unexplained(gyro, known.axis, known.sign);
  return weight_ / 2 * std::log(left / std::max(best, kMinVariance)) > options_.min_lead;
}

// The likelihood of an axis is that of normal residuals with unknown variance.
GyroAxis GyroAxes::judge(int gyro) const {
  GyroAxis out;
  if (weight_ < options_.min_intervals) {
    out.reason = "too little motion was measured";
    return out;
  }
  const int row = 3 + gyro;
  const double variance = scatter_(row, row) / weight_;
  double best = std::numeric_limits<double>::infinity(), second = variance;  // it measures nothing
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      const double left = unexplained(gyro, axis, sign);
      if (left < best) {
        second = std::min(second, best);
        best = left;
        out.axis = axis;
        out.sign = sign;
      } else {
        second = std::min(second, left);
      }
    }
  }
  const double lead = weight_ / 2 * std::log(std::max(second, kMinVariance) / best);
  const double scale =
      out.sign * scatter_(row, out.axis) / std::max(scatter_(out.axis, out.axis), kMinVariance);
  if (lead < options_.min_lead || best > options_.max_unexplained * variance) {
    out.axis = -1;
    out.reason = "the motion does not determine its axis";
  } else if (std::abs(scale - 1) > options_.max_scale_error) {
    out.axis = -1;
    out.reason = "it does not measure what the lidar does";
  } else {
    out.bias = mean_[row] - out.sign * mean_[out.axis];
    out.noise = std::sqrt(std::max(best * per_interval_, within_[gyro]));
    out.reason = "";
  }
  return out;
}

std::optional<AngularVelocity> GyroAxes::measure(const GyroReadings& readings) const {
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();
  Eigen::Array3d missing = Eigen::Array3d::Ones();  // of the lidar's axes
  AngularVelocity out{.stamp = readings.stamp};
  for (size_t gyro = 0; gyro < 3; ++gyro) {
    const GyroAxis& axis = axes_[gyro];
    if (!axis.known() || !std::isfinite(readings.rate[gyro])) continue;
    rate[axis.axis] = axis.sign * (readings.rate[gyro] - axis.bias);
    missing[axis.axis] = 0;
    out.noise = std::max(out.noise, axis.noise);
  }
  const Eigen::Vector3d turned = R_vehicle_lidar_ * rate;
  const Eigen::Vector3d without = R_vehicle_lidar_.cwiseAbs() * missing.matrix();
  for (int i = 0; i < 3; ++i) {
    out.value[static_cast<size_t>(i)] =
        without[i] <= options_.max_missing ? turned[i] : std::nan("");
  }
  if (!std::isfinite(out.value[2])) return std::nullopt;
  return out;
}

}  // namespace infuse::motion
