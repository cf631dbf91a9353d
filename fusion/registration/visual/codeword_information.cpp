#include "fusion/registration/visual/codeword_information.hpp"

#include <bit>
#include <cmath>
#include <limits>

namespace infuse::registration {
namespace {

constexpr float kMaxCells = 1e6F;  // whole in single precision; farther points share the border's

}  // namespace

int32_t CodewordGrid::cell_of(float coordinate) const {
  const float cell = std::floor(coordinate * cells_per_metre_);
  return static_cast<int32_t>(std::min(std::max(cell, -kMaxCells), kMaxCells));
}

size_t CodewordGrid::bucket_of(int32_t column, int32_t row) const {
  const auto key =
      static_cast<uint64_t>(static_cast<uint32_t>(column)) << 32 | static_cast<uint32_t>(row);
  return static_cast<size_t>(key * 0x9E3779B97F4A7C15ULL >> 32) & mask_;
}

void CodewordGrid::build(const CodewordCloud& cloud, double cell) {
  cells_per_metre_ = static_cast<float>(1 / cell);
  mask_ = std::bit_ceil(4 * std::max<size_t>(cloud.size(), 16)) - 1;
  first_.assign(mask_ + 3, 0);
  entries_.resize(cloud.size());
  // Counting sort: counts two ahead, so that the second pass leaves the first entries in place.
  const auto each = [&](auto&& use) {
    for (size_t i = 0; i < cloud.size(); ++i) {
      const Eigen::Vector3f p = cloud.points.col(static_cast<Eigen::Index>(i));
      if (p.allFinite()) use(bucket_of(cell_of(p.x()), cell_of(p.y())), p, i);
    }
  };
  each([&](size_t bucket, const Eigen::Vector3f&, size_t) { ++first_[bucket + 2]; });
  for (size_t b = 2; b < first_.size(); ++b) first_[b] += first_[b - 1];
  each([&](size_t bucket, const Eigen::Vector3f& p, size_t i) {
    entries_[first_[bucket + 1]++] = {p.x(), p.y(), p.z(), static_cast<uint32_t>(i)};
  });
}

CodewordInformation::CodewordInformation(const Codebook& codebook, const CodewordCloud& target,
                                         ShrinkageRule rule, double sigma)
    : target_(target), rule_(rule), sigma_(sigma), information_(codebook.frequencies) {
  const Eigen::Index words = codebook.words.cols();
  dissimilarity_.reserve(static_cast<size_t>(words * words));
  for (Eigen::Index i = 0; i < words; ++i) {
    for (Eigen::Index j = 0; j < words; ++j) {
      dissimilarity_.push_back((codebook.words.col(i) - codebook.words.col(j)).squaredNorm());
    }
  }
}

void CodewordInformation::set_radius(double radius) {
  radius_ = static_cast<float>(radius);
  grid_.build(target_, radius);
}

double CodewordInformation::evaluate(const CodewordCloud& source,
                                     const Eigen::Isometry3d& T_target_source) {
  constexpr float kNone = std::numeric_limits<float>::infinity();
  information_.clear();
  pairs_.clear();
  const Eigen::Matrix3f R = T_target_source.linear().cast<float>();
  const Eigen::Vector3f t = T_target_source.translation().cast<float>();
  const float square_radius = radius_ * radius_;
  const size_t labels = information_.labels();
  for (size_t i = 0; i < source.size(); ++i) {
    const Eigen::Vector3f p = R * source.points.col(static_cast<Eigen::Index>(i)) + t;
    if (!p.allFinite()) continue;
    const float* dissimilarity = &dissimilarity_[source.words[i] * labels];
    float least = kNone, nearest = kNone;
    uint32_t partner = 0;
    grid_.visit_around(p.x(), p.y(), [&](const CodewordGrid::Entry& q) {
      const float dx = q.x - p.x(), dy = q.y - p.y(), dz = q.z - p.z();
      const float distance = dx * dx + dy * dy + dz * dz;
      if (distance > square_radius) return;
      const float unlike = dissimilarity[target_.words[q.index]];
      if (unlike > least || (unlike == least && distance >= nearest)) return;
      least = unlike;
      nearest = distance;
      partner = q.index;
    });
    if (least == kNone) continue;
    information_.add(source.words[i], target_.words[partner]);
    pairs_.push_back({partner, static_cast<uint32_t>(i)});
  }
  switch (rule_) {
    case ShrinkageRule::kByCorrespondences:
      return information_.value(dependence::fast_shrinkage(information_.total(), sigma_));
    case ShrinkageRule::kOptimal:
      return information_.value(information_.optimal_shrinkage());
    case ShrinkageRule::kNone:
      return information_.value(0);
  }
  return 0;
}

}  // namespace infuse::registration
