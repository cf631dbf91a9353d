#include "fusion/streetmap/particle_set.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace infuse::streetmap {
namespace {

/// A square root L of a covariance, L Lᵀ = C; directions without variance are let be.
template <int N>
Eigen::Matrix<double, N, N> root(const Eigen::Matrix<double, N, N>& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, N, N>> solver(
      (covariance + covariance.transpose()) / 2);
  return solver.eigenvectors() * solver.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
}

/// What a particle holds: x, y, yaw, scale, rate.
using Hypothesis = Eigen::Matrix<double, 5, 1>;

Hypothesis difference(const Particle& from, const Particle& to) {
  return {to.pose.x - from.pose.x, to.pose.y - from.pose.y, wrapped(to.pose.yaw - from.pose.yaw),
          to.scale - from.scale, to.rate - from.rate};
}

void add(Particle& particle, const Hypothesis& d) {
  particle.pose.x += d[0];
  particle.pose.y += d[1];
  particle.pose.yaw = wrapped(particle.pose.yaw + d[2]);
  particle.scale += d[3];
  particle.rate += d[4];
}

}  // namespace

double PoseMoments::spread() const {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(
      Eigen::Matrix2d(covariance.topLeftCorner<2, 2>()), Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(solver.eigenvalues().maxCoeff(), 0.0));
}

ParticleSet::ParticleSet(const ParticleOptions& options, uint64_t seed)
    : options_(options), random_(seed) {
  const auto most = static_cast<size_t>(options.most);
  particles_.reserve(most);
  drawn_.reserve(most);
  weights_.reserve(most);
  bins_.reserve(most);
}

void ParticleSet::draw_lasting(Particle& particle) {
  particle.scale = 1 + options_.scale_sigma * normal();
  particle.rate = options_.rate_sigma * normal();
}

void ParticleSet::scatter(const PlanarPose& mean, const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix3d L = root<3>(covariance);
  const auto draw = [&](int count) {
    particles_.resize(static_cast<size_t>(count));
    for (Particle& particle : particles_) {
      const Eigen::Vector3d d = L * Eigen::Vector3d(normal(), normal(), normal());
      particle = {{mean.x + d.x(), mean.y + d.y(), wrapped(mean.yaw + d.z())}};
      draw_lasting(particle);
    }
  };
  draw(options_.most);
  const int needed = number_needed();
  particles_.resize(static_cast<size_t>(needed));
}

void ParticleSet::scatter_disc(const PlanarPose& middle, double radius, double yaw) {
  std::uniform_real_distribution<double> share(0, 1);
  particles_.resize(static_cast<size_t>(options_.most));
  for (Particle& particle : particles_) {
    const double r = radius * std::sqrt(share(random_));
    const double a = 2 * std::numbers::pi * share(random_);
    const double turned = yaw * (2 * share(random_) - 1);
    particle = {
        {middle.x + r * std::cos(a), middle.y + r * std::sin(a), wrapped(middle.yaw + turned)}};
    draw_lasting(particle);
  }
}

void ParticleSet::add_place(const PlanarPose& mean, const Eigen::Matrix3d& covariance) {
  normalise();
  const double even = -std::log(static_cast<double>(particles_.size()));
  const Eigen::Matrix3d L = root<3>(covariance);
  for (size_t i = 0; i < particles_.size(); ++i) {
    Particle& particle = particles_[i];
    particle.log_weight = std::log(std::max(weights_[i], 1e-300));
    particle.elsewhere = i % 3 == 0;
    if (!particle.elsewhere) continue;
    const Eigen::Vector3d d = L * Eigen::Vector3d(normal(), normal(), normal());
    particle.pose = {mean.x + d.x(), mean.y + d.y(), wrapped(mean.yaw + d.z())};
    particle.log_weight = even;
  }
  normalise();
}

double ParticleSet::doubt() const {
  double sum = 0, elsewhere = 0;
  for (const Particle& particle : particles_) {
    const double weight = std::exp(particle.log_weight);
    sum += weight;
    if (particle.elsewhere) elsewhere += weight;
  }
  return sum > 0 ? std::min(elsewhere, sum - elsewhere) / sum : 0;
}

// Two places are one once one of them holds nearly all of the weight, or they lie within a
// deviation of each other.
void ParticleSet::settle_places() {
  const double weight = doubt();
  if (weight == 0) return;
  const PoseMoments here = moments_of(false), there = moments_of(true);
  const Eigen::Vector2d apart(there.mean.x - here.mean.x, there.mean.y - here.mean.y);
  const Eigen::Matrix2d spread = (here.covariance + there.covariance).topLeftCorner<2, 2>() +
                                 1e-6 * Eigen::Matrix2d::Identity();
  if (weight > 0.02 && apart.dot(spread.inverse() * apart) > 1) return;
  for (Particle& particle : particles_) particle.elsewhere = false;
}

void ParticleSet::move(const PlanarPose& motion, const Eigen::Matrix3d& covariance,
                       double seconds) {
  const double distance = std::hypot(motion.x, motion.y);
  Eigen::Matrix3d own = Eigen::Matrix3d::Zero();
  own(0, 0) = own(1, 1) = options_.distance_noise * options_.distance_noise * distance;
  own(2, 2) =
      options_.yaw_noise * options_.yaw_noise * distance + options_.yaw_rest * options_.yaw_rest;
  const Eigen::Matrix3d L = root<3>(covariance + own);
  // What lasts stays near what it was, and within its deviation in the long run.
  const double scale_kept = std::exp(-distance / options_.scale_memory);
  const double scale_walk = options_.scale_sigma * std::sqrt(1 - scale_kept * scale_kept);
  const double rate_kept = std::exp(-seconds / options_.rate_memory);
  const double rate_walk = options_.rate_sigma * std::sqrt(1 - rate_kept * rate_kept);
  for (Particle& particle : particles_) {
    const Eigen::Vector3d d = L * Eigen::Vector3d(normal(), normal(), normal());
    const double scale = particle.scale, turned = particle.rate * seconds;
    particle.pose = particle.pose.then(
        {scale * motion.x + d.x(), scale * motion.y + d.y(), motion.yaw + turned + d.z()});
    particle.scale = 1 + scale_kept * (scale - 1) + scale_walk * normal();
    particle.rate = rate_kept * particle.rate + rate_walk * normal();
  }
}

void ParticleSet::learn(std::span<const double> scores, double within, double between,
                        double reach) {
  normalise();
  const size_t count = particles_.size();
  for (size_t i = 0; i < count; ++i) {
    double around = scores[i];
    if (within != between) {
      const PlanarPose& at = particles_[i].pose;
      double sum = 0, scored = 0;
      for (size_t k = 0; k < count; ++k) {
        const double dx = particles_[k].pose.x - at.x, dy = particles_[k].pose.y - at.y;
        const double near = std::max(0.0, 1 - (dx * dx + dy * dy) / (reach * reach));
        sum += near * weights_[k];
        scored += near * weights_[k] * scores[k];
      }
      around = sum > 0 ? scored / sum : around;
    }
    particles_[i].log_weight += within * (scores[i] - around) + between * around;
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

// Fox's bound (KLD sampling, 2003) for an error of 0.05 with 99 %, by the bins that are occupied.
int ParticleSet::number_needed() {
  bins_.clear();
  for (const Particle& particle : particles_) {
    const auto part = [](double value, double bin) {
      return static_cast<uint64_t>(static_cast<int64_t>(std::floor(value / bin))) & 0x1FFFFFU;
    };
    bins_.push_back(part(particle.pose.x, options_.bin) << 42 |
                    part(particle.pose.y, options_.bin) << 21 |
                    part(particle.pose.yaw, options_.bin_yaw));
  }
  std::sort(bins_.begin(), bins_.end());
  const auto occupied =
      static_cast<double>(std::unique(bins_.begin(), bins_.end()) - bins_.begin());
  if (occupied < 2) return options_.fewest;
  const double k = occupied - 1, a = 2 / (9 * k);
  const double needed = k / (2 * 0.05) * std::pow(1 - a + std::sqrt(a) * 2.33, 3);
  return static_cast<int>(std::clamp(std::ceil(needed), static_cast<double>(options_.fewest),
                                     static_cast<double>(options_.most)));
}

bool ParticleSet::resample_if_needed() {
  normalise();
  settle_places();
  if (effective() > 0.5 * static_cast<double>(particles_.size())) return false;
  const auto draw = [&](int count) {
    std::uniform_real_distribution<double> share(0, 1);
    const double step = 1.0 / count;
    double pointer = step * share(random_), reached = weights_[0];
    size_t at = 0;
    drawn_.clear();
    for (int i = 0; i < count; ++i, pointer += step) {
      while (reached < pointer && at + 1 < particles_.size()) reached += weights_[++at];
      drawn_.push_back(particles_[at]);
    }
  };
  draw(options_.most);
  std::swap(particles_, drawn_);
  const int needed = number_needed();
  std::swap(particles_, drawn_);
  draw(needed);
  std::swap(particles_, drawn_);
  for (Particle& particle : particles_) particle.log_weight = 0;
  spread_copies();
  normalise();
  return true;
}

// Liu and West's kernel (2001): all that a particle holds is drawn towards the mean of its place
// and spread by a share of the covariance there. So mean and covariance stay what they are, the
// errors that last stay tied to the poses that they led to, and no copies are left.
void ParticleSet::spread_copies() {
  const double width = options_.kernel, kept = std::sqrt(1 - width * width);
  for (const bool elsewhere : {false, true}) {
    const auto of_place = [&](const Particle& p) { return p.elsewhere == elsewhere; };
    const auto first = std::find_if(particles_.begin(), particles_.end(), of_place);
    if (first == particles_.end()) continue;
    Particle middle = *first;
    Hypothesis sum = Hypothesis::Zero();
    double count = 0;
    for (const Particle& particle : particles_) {
      if (!of_place(particle)) continue;
      sum += difference(middle, particle);
      ++count;
    }
    add(middle, sum / count);
    Eigen::Matrix<double, 5, 5> covariance = Eigen::Matrix<double, 5, 5>::Zero();
    for (const Particle& particle : particles_) {
      if (!of_place(particle)) continue;
      const Hypothesis d = difference(middle, particle);
      covariance += d * d.transpose() / count;
    }
    const Eigen::Matrix<double, 5, 5> L = width * root<5>(covariance);
    for (Particle& particle : particles_) {
      if (!of_place(particle)) continue;
      const Hypothesis n(normal(), normal(), normal(), normal(), normal());
      add(particle, (kept - 1) * difference(middle, particle) + L * n);
      particle.pose.x += options_.jitter * normal();
      particle.pose.y += options_.jitter * normal();
      particle.pose.yaw = wrapped(particle.pose.yaw + options_.jitter_yaw * normal());
    }
  }
}

PoseMoments ParticleSet::moments() const {
  double places[2] = {0, 0};
  for (const Particle& particle : particles_) {
    places[particle.elsewhere] += std::exp(particle.log_weight);
  }
  return moments_of(places[1] > places[0]);
}

PoseMoments ParticleSet::moments_of(bool elsewhere) const {
  PoseMoments moments;
  double sum = 0, x = 0, y = 0, c = 0, s = 0;
  for (const Particle& particle : particles_) {
    if (particle.elsewhere != elsewhere) continue;
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
    if (particle.elsewhere != elsewhere) continue;
    const Eigen::Vector3d d(particle.pose.x - moments.mean.x, particle.pose.y - moments.mean.y,
                            wrapped(particle.pose.yaw - moments.mean.yaw));
    moments.covariance += std::exp(particle.log_weight) / sum * d * d.transpose();
  }
  return moments;
}

double ParticleSet::effective() const {
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
