#include "fusion/streetmap/particle_set.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "fusion/geometry/plane_length.hpp"
#include "fusion/geometry/symmetric_eigen.hpp"

namespace infuse::streetmap {
namespace {

/// Returns a square root L of a covariance, L Lᵀ = C: Cholesky's, where directions without variance
/// are zero. Not from eigenvectors: the last bit of a nearly round covariance turns those.
template <int N>
Eigen::Matrix<double, N, N> matrix_sqrt(const Eigen::Matrix<double, N, N>& covariance) {
  Eigen::Matrix<double, N, N> L = Eigen::Matrix<double, N, N>::Zero();
  for (int j = 0; j < N; ++j) {
    double variance = covariance(j, j);
    for (int k = 0; k < j; ++k) variance -= L(j, k) * L(j, k);
    if (!(variance > 1e-12 * covariance(j, j))) continue;
    L(j, j) = std::sqrt(variance);
    for (int i = j + 1; i < N; ++i) {
      double sum = (covariance(i, j) + covariance(j, i)) / 2;
      for (int k = 0; k < j; ++k) sum -= L(i, k) * L(j, k);
      L(i, j) = sum / L(j, j);
    }
  }
  return L;
}

/// State vector of a particle: x, y, yaw, scale, yaw-rate bias.
using ParticleState = Eigen::Matrix<double, 5, 1>;

ParticleState difference(const Particle& from, const Particle& to) {
  return {to.pose.x - from.pose.x, to.pose.y - from.pose.y, wrap_angle(to.pose.yaw - from.pose.yaw),
          to.scale - from.scale, to.yaw_rate_bias - from.yaw_rate_bias};
}

void add(Particle& particle, const ParticleState& d) {
  particle.pose.x += d[0];
  particle.pose.y += d[1];
  particle.pose.yaw = wrap_angle(particle.pose.yaw + d[2]);
  particle.scale += d[3];
  particle.yaw_rate_bias += d[4];
}

/// True if odometry is sure that the vehicle stands.
bool is_standing(const PlanarPose& motion, const Eigen::Matrix3d& covariance, double seconds) {
  constexpr double kMaxSpeed = 0.05;    // m/s
  constexpr double kMaxYawRate = 0.01;  // rad/s
  constexpr double kMaxSigma = 0.02;    // m
  return geometry::plane_length(motion.x, motion.y) <= kMaxSpeed * seconds &&
         std::abs(motion.yaw) <= kMaxYawRate * seconds &&
         covariance(0, 0) + covariance(1, 1) <= kMaxSigma * kMaxSigma;
}

}  // namespace

double PoseMoments::spread() const {
  const auto eigen = geometry::symmetric_eigen<2>(covariance.topLeftCorner<2, 2>());
  return std::sqrt(std::max(eigen.values[1], 0.0));
}

ParticleSet::ParticleSet(const ParticleOptions& options, uint64_t seed)
    : options_(options), random_(seed) {
  const auto max_count = static_cast<size_t>(options.max_count);
  particles_.reserve(max_count);
  resampled_.reserve(max_count);
  weights_.reserve(max_count);
  bins_.reserve(max_count);
}

void ParticleSet::draw_odometry_errors(Particle& particle) {
  particle.scale = 1 + options_.scale_sigma * normal();
  particle.yaw_rate_bias = options_.yaw_rate_bias_sigma * normal();
}

void ParticleSet::scatter(const PlanarPose& mean, const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix3d L = matrix_sqrt<3>(covariance);
  const auto draw = [&](int count) {
    particles_.resize(static_cast<size_t>(count));
    for (Particle& particle : particles_) {
      const Eigen::Vector3d d = L * Eigen::Vector3d{normal(), normal(), normal()};
      particle = {{mean.x + d.x(), mean.y + d.y(), wrap_angle(mean.yaw + d.z())}};
      draw_odometry_errors(particle);
    }
  };
  draw(options_.max_count);
  const int needed = required_count();
  particles_.resize(static_cast<size_t>(needed));
}

void ParticleSet::add_mode(const PlanarPose& mean, const Eigen::Matrix3d& covariance) {
  normalise();
  const auto [first, second] = mode_weights();
  const bool two = first > 0 && second > 0, less_likely = second <= first;
  const auto given_up = [&](const Particle& p) { return two && p.in_second_mode == less_likely; };
  const bool few = std::ranges::count_if(particles_, given_up) <
                   static_cast<std::ptrdiff_t>(particles_.size() / 6);
  const double even = -std::log(static_cast<double>(particles_.size()));
  const Eigen::Matrix3d L = matrix_sqrt<3>(covariance);
  size_t others = 0;
  for (size_t i = 0; i < particles_.size(); ++i) {
    Particle& particle = particles_[i];
    particle.log_weight = std::log(std::max(weights_[i], 1e-300));
    particle.in_second_mode = given_up(particle) || (few && others++ % 3 == 0);
    if (!particle.in_second_mode) continue;
    const Eigen::Vector3d d = L * Eigen::Vector3d{normal(), normal(), normal()};
    particle.pose = {mean.x + d.x(), mean.y + d.y(), wrap_angle(mean.yaw + d.z())};
    particle.log_weight = even;
  }
  normalise();
}

double ParticleSet::second_mode_weight() const {
  const auto [first, second] = mode_weights();
  return first + second > 0 ? std::min(first, second) / (first + second) : 0;
}

// Two modes are merged once one of them holds nearly all of the weight or they lie within one
// standard deviation of each other.
void ParticleSet::merge_modes() {
  const double weight = second_mode_weight();
  if (weight == 0) return;
  const PoseMoments first_mode = moments_of_mode(false), second_mode = moments_of_mode(true);
  const Eigen::Vector2d difference_xy(second_mode.mean.x - first_mode.mean.x,
                                      second_mode.mean.y - first_mode.mean.y);
  const Eigen::Matrix2d spread =
      (first_mode.covariance + second_mode.covariance).topLeftCorner<2, 2>() +
      1e-6 * Eigen::Matrix2d::Identity();
  if (weight > 0.02 && difference_xy.dot(spread.inverse() * difference_xy) > 1) return;
  for (Particle& particle : particles_) particle.in_second_mode = false;
}

void ParticleSet::predict(const PlanarPose& motion, const Eigen::Matrix3d& covariance,
                          double seconds) {
  const double distance = geometry::plane_length(motion.x, motion.y);
  // No bias moves a vehicle that stands, nor is anything learned of it.
  if (is_standing(motion, covariance, seconds)) {
    for (Particle& particle : particles_) particle.pose = particle.pose.compose(motion);
    return;
  }
  Eigen::Matrix3d own = Eigen::Matrix3d::Zero();
  own(0, 0) = own(1, 1) = options_.distance_noise * options_.distance_noise * distance;
  own(2, 2) = options_.yaw_noise * options_.yaw_noise * distance +
              options_.yaw_noise_per_update * options_.yaw_noise_per_update;
  const Eigen::Matrix3d L = matrix_sqrt<3>(covariance + own);
  // Persistent errors change slowly and keep their stationary standard deviation.
  const double scale_decay = std::exp(-distance / options_.scale_correlation_distance);
  const double scale_walk = options_.scale_sigma * std::sqrt(1 - scale_decay * scale_decay);
  const double rate_decay = std::exp(-seconds / options_.yaw_rate_bias_correlation_time);
  const double rate_walk = options_.yaw_rate_bias_sigma * std::sqrt(1 - rate_decay * rate_decay);
  for (Particle& particle : particles_) {
    const Eigen::Vector3d d = L * Eigen::Vector3d{normal(), normal(), normal()};
    const double scale = particle.scale, turned = particle.yaw_rate_bias * seconds;
    particle.pose = particle.pose.compose(
        {scale * motion.x + d.x(), scale * motion.y + d.y(), motion.yaw + turned + d.z()});
    particle.scale = 1 + scale_decay * (scale - 1) + scale_walk * normal();
    particle.yaw_rate_bias = rate_decay * particle.yaw_rate_bias + rate_walk * normal();
  }
}

void ParticleSet::update_weights(std::span<const double> scores, double within_gain,
                                 double between_gain, double radius) {
  normalise();
  const size_t count = particles_.size();
  for (size_t i = 0; i < count; ++i) {
    double local_score = scores[i];
    if (within_gain != between_gain) {
      const PlanarPose& at = particles_[i].pose;
      double sum = 0, scored = 0;
      for (size_t k = 0; k < count; ++k) {
        const double dx = particles_[k].pose.x - at.x, dy = particles_[k].pose.y - at.y;
        const double kernel_weight = std::max(0.0, 1 - (dx * dx + dy * dy) / (radius * radius));
        sum += kernel_weight * weights_[k];
        scored += kernel_weight * weights_[k] * scores[k];
      }
      local_score = sum > 0 ? scored / sum : local_score;
    }
    particles_[i].log_weight +=
        within_gain * (scores[i] - local_score) + between_gain * local_score;
  }
}

void ParticleSet::normalise() {
  double largest = -std::numeric_limits<double>::infinity();
  for (const Particle& particle : particles_) largest = std::max(largest, particle.log_weight);
  weights_.resize(particles_.size());
  double sum = 0;
  for (size_t i = 0; i < particles_.size(); ++i) {
    particles_[i].log_weight -= largest;
    weights_[i] = std::exp(particles_[i].log_weight);
    sum += weights_[i];
  }
  for (double& weight : weights_) weight /= sum;
}

// Fox's bound (KLD sampling, 2003) for an error of 0.05 with 99 %, by the number of occupied bins.
int ParticleSet::required_count() {
  bins_.clear();
  for (const Particle& particle : particles_) {
    const auto part = [](double value, double bin) {
      return static_cast<uint64_t>(static_cast<int64_t>(std::floor(value / bin))) & 0x1FFFFFU;
    };
    bins_.push_back(part(particle.pose.x, options_.bin_size) << 42 |
                    part(particle.pose.y, options_.bin_size) << 21 |
                    part(particle.pose.yaw, options_.yaw_bin_size));
  }
  std::sort(bins_.begin(), bins_.end());
  const auto occupied =
      static_cast<double>(std::unique(bins_.begin(), bins_.end()) - bins_.begin());
  if (occupied < 2) return options_.min_count;
  const double k = occupied - 1, a = 2 / (9 * k);
  const double needed = k / (2 * 0.05) * std::pow(1 - a + std::sqrt(a) * 2.33, 3);
  return static_cast<int>(std::clamp(std::ceil(needed), static_cast<double>(options_.min_count),
                                     static_cast<double>(options_.max_count)));
}

bool ParticleSet::resample_if_needed() {
  normalise();
  merge_modes();
  if (effective_count() > 0.5 * static_cast<double>(particles_.size())) return false;
  const auto draw = [&](int count) {
    std::uniform_real_distribution<double> share(0, 1);
    const double step = 1.0 / count;
    double pointer = step * share(random_), reached = weights_[0];
    size_t at = 0;
    resampled_.clear();
    for (int i = 0; i < count; ++i, pointer += step) {
      while (reached < pointer && at + 1 < particles_.size()) reached += weights_[++at];
      resampled_.push_back(particles_[at]);
    }
  };
  draw(options_.max_count);
  std::swap(particles_, resampled_);
  const int needed = required_count();
  std::swap(particles_, resampled_);
  draw(needed);
  std::swap(particles_, resampled_);
  for (Particle& particle : particles_) particle.log_weight = 0;
  smooth_with_kernel();
  normalise();
  return true;
}

// Kernel of Liu and West (2001): each state is shrunk towards the mean of its mode and spread by a
// share of its covariance. Mean and covariance stay the same, persistent errors stay correlated
// with the poses that they led to, and no identical copies remain.
void ParticleSet::smooth_with_kernel() {
  const double width = options_.kernel_width, shrinkage = std::sqrt(1 - width * width);
  for (const bool second_mode : {false, true}) {
    const auto in_mode = [&](const Particle& p) { return p.in_second_mode == second_mode; };
    const auto first = std::find_if(particles_.begin(), particles_.end(), in_mode);
    if (first == particles_.end()) continue;
    Particle middle = *first;
    ParticleState sum = ParticleState::Zero();
    double count = 0;
    for (const Particle& particle : particles_) {
      if (!in_mode(particle)) continue;
      sum += difference(middle, particle);
      ++count;
    }
    add(middle, sum / count);
    Eigen::Matrix<double, 5, 5> covariance = Eigen::Matrix<double, 5, 5>::Zero();
    for (const Particle& particle : particles_) {
      if (!in_mode(particle)) continue;
      const ParticleState d = difference(middle, particle);
      covariance += d * d.transpose() / count;
    }
    const Eigen::Matrix<double, 5, 5> L = width * matrix_sqrt<5>(covariance);
    for (Particle& particle : particles_) {
      if (!in_mode(particle)) continue;
      const ParticleState n{normal(), normal(), normal(), normal(), normal()};
      add(particle, (shrinkage - 1) * difference(middle, particle) + L * n);
      particle.pose.x += options_.jitter * normal();
      particle.pose.y += options_.jitter * normal();
      particle.pose.yaw = wrap_angle(particle.pose.yaw + options_.jitter_yaw * normal());
    }
  }
}

std::array<double, 2> ParticleSet::mode_weights() const {
  std::array<double, 2> weights{};
  for (const Particle& particle : particles_) {
    weights[particle.in_second_mode] += std::exp(particle.log_weight);
  }
  return weights;
}

PoseMoments ParticleSet::moments() const {
  const auto [first, second] = mode_weights();
  return moments_of_mode(second > first);
}

std::optional<PoseMoments> ParticleSet::second_moments() const {
  const auto [first, second] = mode_weights();
  if (first == 0 || second == 0) return std::nullopt;
  return moments_of_mode(second <= first);
}

PoseMoments ParticleSet::moments_of_mode(bool second_mode) const {
  PoseMoments moments;
  double sum = 0, x = 0, y = 0, c = 0, s = 0;
  for (const Particle& particle : particles_) {
    if (particle.in_second_mode != second_mode) continue;
    const double weight = std::exp(particle.log_weight);
    sum += weight;
    x += weight * particle.pose.x;
    y += weight * particle.pose.y;
    c += weight * std::cos(particle.pose.yaw);
    s += weight * std::sin(particle.pose.yaw);
  }
  if (!(sum > 0)) return moments;
  moments.mean = {x / sum, y / sum, std::atan2(s, c)};
  for (const Particle& particle : particles_) {
    if (particle.in_second_mode != second_mode) continue;
    const Eigen::Vector3d d(particle.pose.x - moments.mean.x, particle.pose.y - moments.mean.y,
                            wrap_angle(particle.pose.yaw - moments.mean.yaw));
    moments.covariance += std::exp(particle.log_weight) / sum * d * d.transpose();
  }
  return moments;
}

double ParticleSet::effective_count() const {
  double sum = 0, squares = 0;
  for (const Particle& particle : particles_) {
    const double weight = std::exp(particle.log_weight);
    sum += weight;
    squares += weight * weight;
  }
  return squares > 0 ? sum * sum / squares : 0;
}

double ParticleSet::entropy() const {
  if (particles_.size() < 2) return 0;
  double sum = 0;
  for (const Particle& particle : particles_) sum += std::exp(particle.log_weight);
  double entropy = 0;
  for (const Particle& particle : particles_) {
    const double share = std::exp(particle.log_weight) / sum;
    if (share > 0) entropy -= share * std::log(share);
  }
  return entropy / std::log(static_cast<double>(particles_.size()));
}

}  // namespace infuse::streetmap
