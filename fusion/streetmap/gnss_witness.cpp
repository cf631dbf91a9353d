#include "fusion/streetmap/gnss_witness.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace infuse::streetmap {
namespace {

constexpr double kOutlier = 3;  // sigmas above which a fix counts less: 98.9 % of χ² with 2 degrees
constexpr double kMaxWorth = 2;  // factor of the standard deviations of a refuted receiver
constexpr double kRefutedFactor = 1.5;
constexpr double kForgiveSeconds = 60;  // s of agreement until a refuted receiver counts as before
constexpr double kMaxHdop = 50;

double square(double x) { return x * x; }

/// Probability that a fix says nothing of the place: beyond `kOutlier` it counts no more.
const double kUseless = std::exp(-square(kOutlier) / 2);

}  // namespace

std::optional<std::string> GnssOptions::invalid() const {
  for (const double positive : {map_sigma, slow_sigma, noise_sigma, unknown_hdop, correlation_time,
                                max_chi_squared, doubt_seconds, silent_seconds}) {
    if (!(positive > 0 && positive <= 1e4)) return "gnss: settings must be between 0 and 10000";
  }
  if (!(lost_seconds >= doubt_seconds)) return "gnss: lost_seconds must reach doubt_seconds";
  return std::nullopt;
}

double GnssWitness::prior_variance() const {
  return square(worth_) * (square(options_.map_sigma) + square(options_.slow_sigma * hdop_));
}

void GnssWitness::advance(double seconds) {
  now_ += seconds;
  if (contradicts_) contradicts_for_ += seconds;
  if (offset_variance_ < 0) return;
  const double decay = std::exp(-seconds / options_.correlation_time);
  offset_ *= decay;
  offset_variance_ = square(decay) * offset_variance_ + (1 - square(decay)) * prior_variance();
}

void GnssWitness::add(const MapFix& fix) {
  if (!fix.position.allFinite()) return;
  const double stated = fix.hdop > 0 ? fix.hdop : options_.unknown_hdop;
  hdop_ = std::clamp(stated, 1.0, kMaxHdop);
  new_evidence_ = std::min(1.0, (now_ - last_fix_) / options_.correlation_time);
  last_fix_ = now_;
  fix_ = fix;
}

void GnssWitness::add(const MapFix& fix, const Eigen::Vector2d& pose, double variance) {
  if (!fix.position.allFinite()) return;
  add(fix);
  track_variance_ = variance;
  if (offset_variance_ < 0) offset_variance_ = prior_variance();
  const Eigen::Vector2d innovation = fix.position - pose - offset_;
  double noise = square(options_.noise_sigma * hdop_) + variance;
  const double sigma = std::sqrt(offset_variance_ + noise);
  if (innovation.norm() > kOutlier * sigma) noise *= innovation.norm() / (kOutlier * sigma);
  const double gain = offset_variance_ / (offset_variance_ + noise);
  offset_ += gain * innovation;
  offset_variance_ *= 1 - gain;
  const double explained = prior_variance() + offset_variance_ + variance;
  contradicts_ = offset_.squaredNorm() > options_.max_chi_squared * explained;
  if (contradicts_) {
    agreed_since_ = now_;
  } else {
    contradicts_for_ = 0;
    if (now_ - agreed_since_ > kForgiveSeconds) worth_ = 1;
  }
}

GnssWitness::Verdict GnssWitness::verdict() const {
  if (!contradicts_ || contradicts_for_ < options_.doubt_seconds) return Verdict::kNone;
  return contradicts_for_ < options_.lost_seconds ? Verdict::kDoubt : Verdict::kLost;
}

double GnssWitness::log_likelihood(const Eigen::Vector2d& position) const {
  const double variance = prior_variance() + square(options_.noise_sigma * hdop_);
  const double chi_squared = (fix_.position - position).squaredNorm() / variance;
  return -0.5 * new_evidence_ * std::min(chi_squared, square(kOutlier));
}

double GnssWitness::log_likelihood_in(double area, const Eigen::Vector2d& position,
                                      bool anew) const {
  const double variance = prior_variance() + square(options_.noise_sigma * hdop_);
  const double by_chance = std::min(kUseless * 2 * std::numbers::pi * variance / area, 1.0);
  const double chi_squared = (fix_.position - position).squaredNorm() / variance;
  return (anew ? 1 : new_evidence_) * std::log(std::exp(-chi_squared / 2) + by_chance);
}

double GnssWitness::log_odds(const Eigen::Vector2d& position,
                             const Eigen::Vector2d& estimate) const {
  if (offset_variance_ < 0 || is_silent()) return 0;
  const double variance = prior_variance() + offset_variance_ + track_variance_;
  const auto likelihood = [&](const Eigen::Vector2d& d) {
    return std::log(std::exp(-d.squaredNorm() / variance / 2) + kUseless);
  };
  return likelihood(estimate + offset_ - position) - likelihood(offset_);
}

// The offset follows slowly what is far from it.
std::optional<GnssWitness::Place> GnssWitness::place(const Eigen::Vector2d& pose) const {
  if (offset_variance_ < 0 || is_silent()) return std::nullopt;
  const double sigma = std::sqrt(prior_variance());
  const Eigen::Vector2d mean = pose + offset_;
  const bool follows = (fix_.position - mean).norm() <= kOutlier * sigma;
  return Place{follows ? mean : fix_.position, fix_.yaw, sigma};
}

std::optional<Eigen::Vector2d> GnssWitness::offset() const {
  if (offset_variance_ < 0) return std::nullopt;
  return offset_;
}

double GnssWitness::offset_sigma() const {
  return std::sqrt(std::max(offset_variance_, 0.0) + track_variance_);
}

void GnssWitness::restart(bool refuted) {
  if (refuted) worth_ = std::min(worth_ * kRefutedFactor, kMaxWorth);
  offset_variance_ = -1;
  offset_.setZero();
  contradicts_ = false;
  contradicts_for_ = 0;
}

}  // namespace infuse::streetmap
