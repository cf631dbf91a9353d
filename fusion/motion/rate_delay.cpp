#include "fusion/motion/rate_delay.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "drivers/measurement/rotation.hpp"
#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/motion/odometry_options.hpp"

namespace infuse::motion {
namespace {

constexpr double kStep = 0.01;  // s between candidates, which a parabola refines: derived from the
                                // lidar's 0.1 s a turn, over which the rates are averaged
constexpr Duration kMaxGap{300'000'000};   // between samples: derived from buses at 10 Hz, two lost
constexpr Duration kBlock{1'000'000'000};  // derived from kSteps: twice what a motion is compared
                                           // with, so that blocks share few samples
constexpr size_t kBlocks = 120;            // bounds the memory: two minutes
// This bounds the memory: 1 s of samples at 1 kHz. Motions wait for the latest candidate, and a
// registration takes a few tenths of a second.
constexpr size_t kAngles = 1024, kWaiting = 64;
constexpr double kIntervalShare = 0.05;  // of the newest in the mean interval: one in twenty
constexpr double kMaxRate = 35;  // rad/s: 2000 °/s, the widest range on the data sheet of a gyro
constexpr double kTurnTimeConstant =
    0.1;  // s, derived from the lidar's turn: changes over it are what shows the delay

Eigen::Array3d squared(const Eigen::Array3d& value) { return value * value; }

}  // namespace

RateDelay::RateDelay() : angles_(kAngles), blocks_(kBlocks) {
  waiting_.reserve(kWaiting);
  for (Block& block : blocks_) {
    block.sum.setZero();
    block.squares.setZero();
  }
  found_.reason = "the lidar's motion was not measured beside the sensor";
}

void RateDelay::reset() {
  angle_count_ = 0;
  waiting_.clear();
  change_.setZero();
}

void RateDelay::add(Stamp stamp, const Eigen::Vector3d& measured) {
  const Eigen::Vector3d rate = (measured.array().abs() < kMaxRate).select(measured, 0.0);
  const Angle last = angles_[newest_];
  if (angle_count_ > 0 && (stamp < last.stamp || stamp - last.stamp > kMaxGap)) reset();
  if (angle_count_ == 0) {
    angles_[newest_] = {stamp, rate, Eigen::Vector3d::Zero()};
    angle_count_ = 1;
    slow_rate_ = rate;
    return;
  }
  const double seconds = to_seconds(stamp - last.stamp);
  if (!(seconds > 0)) return;
  interval_ += (interval_ > 0 ? kIntervalShare : 1) * (seconds - interval_);
  newest_ = (newest_ + 1) % kAngles;
  angle_count_ = std::min(angle_count_ + 1, kAngles);
  angles_[newest_] = {stamp, rate, last.sum + 0.5 * seconds * (last.rate + rate)};
  // A low-pass lags behind a ramp by dt / (1 − decay).
  const double follow = 1 - std::exp(-seconds / kTurnTimeConstant);
  slow_rate_ += follow * (last.rate - slow_rate_);
  change_ = (rate - slow_rate_) * follow / seconds;
  compare_waiting();
}

Eigen::Vector3d RateDelay::change_before(Stamp stamp) const {
  if (angle_count_ == 0 || stamp - angles_[newest_].stamp > kMaxGap) return Eigen::Vector3d::Zero();
  return change_;
}

void RateDelay::add(const RelativePose& motion) {
  if (waiting_.size() == kWaiting) waiting_.erase(waiting_.begin());
  waiting_.push_back(motion);
  compare_waiting();
}

void RateDelay::compare_waiting() {
  if (angle_count_ == 0) return;
  const Duration margin = from_seconds(kSteps * kStep) + kMaxGap / 2;
  const Stamp newest = angles_[newest_].stamp;
  const auto compared = std::remove_if(waiting_.begin(), waiting_.end(), [&](const auto& motion) {
    if (motion.to + margin > newest) return false;
    compare(motion);
    return true;
  });
  waiting_.erase(compared, waiting_.end());
}

const RateDelay::Angle& RateDelay::angle(size_t i) const {
  return angles_[(newest_ + kAngles + 1 - angle_count_ + i) % kAngles];
}

Eigen::Vector3d RateDelay::angle_at(Stamp stamp) const {
  size_t from = 0, to = angle_count_ - 1;
  while (to - from > 1) {
    const size_t middle = (from + to) / 2;
    (angle(middle).stamp <= stamp ? from : to) = middle;
  }
  const Angle &a = angle(from), &b = angle(to);
  const double part = to_seconds(stamp - a.stamp), seconds = to_seconds(b.stamp - a.stamp);
  return a.sum + part * (a.rate + 0.5 * part / seconds * (b.rate - a.rate));
}

// Between samples, their noise is averaged: it would prefer delays at which motions begin between
// two. The mean over half an interval either way has nearly the same noise everywhere.
void RateDelay::compare(const RelativePose& motion) {
  const double seconds = to_seconds(motion.to - motion.from);
  const Duration interval = (angle(angle_count_ - 1).stamp - angle(0).stamp) /
                            static_cast<int64_t>(std::max<size_t>(1, angle_count_ - 1));
  const Duration half = interval / 2;
  const Stamp first = motion.from - from_seconds(kSteps * kStep) - half;
  if (!(seconds > 0) || first < angle(0).stamp) return;
  const auto angle_about = [&](Stamp stamp) -> Eigen::Array3d {
    return 0.5 * (angle_at(stamp - half) + angle_at(stamp + half));
  };
  if (blocks_[block_].count == 0) blocks_[block_].begin = motion.from;
  if (motion.from - blocks_[block_].begin >= kBlock || motion.from < blocks_[block_].begin)
    next_block(motion.from);
  const Eigen::Array3d measured =
      geometry::rotation_log(motion.T_from_to.linear()).array() / seconds;
  Block& block = blocks_[block_];
  block.count += 1;
  for (int i = 0; i <= kCandidates; ++i) {
    Eigen::Array3d error = measured;
    if (i < kCandidates) {
      const Duration shift = from_seconds((i - kSteps) * kStep);
      error -= (angle_about(motion.to + shift) - angle_about(motion.from + shift)) / seconds;
    }
    block.sum.col(i) += error;
    block.squares.col(i) += squared(error);
  }
}

// Angular rates are rounded: an axis that is not measured has no error at all.
constexpr double kRoundedVariance = 1e-12;  // (rad/s)²

RateDelay::Rates RateDelay::variance_of(const Block& total, Eigen::Index i) {
  return total.squares.col(i) / total.count - squared(total.sum.col(i) / total.count) +
         kRoundedVariance;
}

const SensorDelay& RateDelay::finish() {
  find();
  return found_;
}

void RateDelay::find() {
  constexpr double kSure = 1e-6;  // one in a million: the rates explain the rotations by chance
  constexpr double kMaxSigma = 0.015;  // s, derived from half a degree in a sharp bend, 0.5 rad/s
  Block total = blocks_[block_];
  for (size_t i = 0; i < kBlocks; ++i) {
    if (i == block_) continue;
    total.count += blocks_[i].count;
    total.sum += blocks_[i].sum;
    total.squares += blocks_[i].squares;
  }
  if (total.count == 0) return;
  Costs costs;  // negative logarithms of the likelihood of errors whose noise is not known
  for (Eigen::Index i = 0; i <= kCandidates; ++i)
    costs[i] = 0.5 * total.count * variance_of(total, i).log().sum();
  Eigen::Index best = 0;
  costs.head<kCandidates>().minCoeff(&best);
  SensorDelay result;
  if (!(costs[best] < costs[kCandidates] + std::log(kSure))) {
    result.reason = "the sensor does not measure the rotation of the lidar";
  } else if (best == 0 || best == kCandidates - 1) {
    result.reason = "the delay is not within 0.25 s";
  } else {
    const double curvature = costs[best - 1] - 2 * costs[best] + costs[best + 1];
    const double offset = 0.5 * (costs[best - 1] - costs[best + 1]) / curvature;
    result.value = kStep * (static_cast<double>(best) - kSteps + offset);
    result.sigma = std::hypot(sigma_at(best, offset, total), spread(costs, best, result.value));
    if (!(result.sigma <= kMaxSigma)) result.reason = "the vehicle turns too little";
  }
  if (found_.usable()) {
    const double at = std::round(found_.value / kStep) + kSteps;
    const bool refuted = costs[static_cast<Eigen::Index>(at)] + std::log(kSure) > costs[best];
    if (!result.usable() && !refuted) return;
  }
  is_new_ = is_new_ || found_.usable() || result.usable();
  found_ = result;
}

// A few seconds of noise may fit another delay nearly as well. The prior is what is assumed of a
// sensor before.
double RateDelay::spread(const Costs& costs, Eigen::Index best, double value) {
  constexpr double kPrior = OdometryOptions{}.imu_delay_sigma;  // s
  constexpr Eigen::Index kNear =
      2;  // candidates, derived from the parabola: that spread is `sigma_at`
  double sum = 0, squares = 0;
  for (Eigen::Index i = 0; i < kCandidates; ++i) {
    const double delay = kStep * static_cast<double>(i - kSteps);
    const double weight = std::exp(costs[best] - costs[i] +
                                   0.5 * (value * value - delay * delay) / (kPrior * kPrior));
    sum += weight;
    if (std::abs(i - best) > kNear) squares += weight * (delay - value) * (delay - value);
  }
  return std::sqrt(squares / sum);
}

// By the scatter of the seconds' gradients (Huber's sandwich), at least by the curvature. Few
// seconds with turns say little of the scatter: the variance is that of Student's t with as many
// degrees of freedom as seconds of equal information, less one (Kish's effective sample size).
double RateDelay::sigma_at(Eigen::Index best, double offset, const Block& total) const {
  const auto mean = [&](Eigen::Index i) -> Eigen::Array3d {
    return total.sum.col(i) / total.count;
  };
  const Eigen::Array3d variance = variance_of(total, best);
  double information = 0, squares = 0, scatter = 0;
  for (const Block& block : blocks_) {
    if (block.count == 0) continue;
    std::array<double, 3> costs{};
    for (Eigen::Index i = 0; i < 3; ++i) {
      const Eigen::Index at = best + i - 1;
      const Eigen::Array3d squares_of = block.squares.col(at) - 2 * mean(at) * block.sum.col(at) +
                                        block.count * squared(mean(at));
      costs[static_cast<size_t>(i)] = 0.5 * (squares_of / variance).sum();
    }
    const double curvature = (costs[0] - 2 * costs[1] + costs[2]) / (kStep * kStep);
    const double gradient = (costs[2] - costs[0]) / (2 * kStep) + offset * kStep * curvature;
    information += curvature;
    squares += curvature * curvature;
    scatter += gradient * gradient;
  }
  const double freedom = information * information / squares - 1;
  if (!(information > 0 && freedom > 2)) return std::numeric_limits<double>::infinity();
  scatter *= (freedom + 1) / freedom * freedom / (freedom - 2);
  return std::sqrt(std::max(scatter, information)) / information;
}

void RateDelay::next_block(Stamp begin) {
  find();
  block_ = (block_ + 1) % kBlocks;
  Block& block = blocks_[block_];
  block.begin = begin;
  block.count = 0;
  block.sum.setZero();
  block.squares.setZero();
}

}  // namespace infuse::motion
