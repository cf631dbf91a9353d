#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "fusion/dependence/shrunk_information.hpp"
#include "fusion/registration/visual/codebook.hpp"

namespace infuse::registration {

/// Shrinkage of the frequencies of codewords towards those of the codebook.
enum class ShrinkageRule : uint8_t {
  kByCorrespondences,  ///< λ_e, P(4.11), reversed: the more correspondences, the less
  kOptimal,            ///< λ_s, P(4.10)
  kNone,               ///< maximum likelihood
};

/// Codewords in cells of a plane, to find those within a radius of a point. Allocates nothing
/// when it is built again from no more codewords.
class CodewordGrid {
 public:
  /// Points that are not finite are left out. `cell` in m.
  void build(const CodewordCloud& cloud, double cell);

  struct Entry {
    float x, y, z;   // m
    uint32_t index;  // in the cloud
  };

  /// Calls `visit(entry)` with the entries of the cell of (x, y) and of the eight around it, and
  /// with some of other cells.
  template <class Visit>
  void visit_around(float x, float y, Visit&& visit) const {
    const int32_t column = cell_of(x), row = cell_of(y);
    for (int32_t r = row - 1; r <= row + 1; ++r) {
      for (int32_t c = column - 1; c <= column + 1; ++c) {
        const size_t bucket = bucket_of(c, r);
        for (uint32_t i = first_[bucket]; i < first_[bucket + 1]; ++i) visit(entries_[i]);
      }
    }
  }

 private:
  int32_t cell_of(float coordinate) const;
  size_t bucket_of(int32_t column, int32_t row) const;

  float cells_per_metre_ = 1;
  size_t mask_ = 0;
  std::vector<uint32_t> first_;  // entries of bucket b: first_[b] … first_[b + 1] − 1
  std::vector<Entry> entries_;
};

/// Corresponding points of two scans, indices into their clouds.
struct CodewordPair {
  uint32_t target, source;
};

/// Mutual information of the corresponding codewords of two scans at a pose: the objective of
/// P(4.9). Each codeword of the source corresponds to the most similar codeword of the target
/// within a radius, the nearest of these if there are several (P fig. 4.14).
class CodewordInformation {
 public:
  /// The clouds and the codebook must outlive the object; both must be usable with each other.
  CodewordInformation(const Codebook& codebook, const CodewordCloud& target, ShrinkageRule rule,
                      double sigma);

  /// Sets the radius of correspondences, m.
  void set_radius(double radius);

  /// Mutual information at a pose, nats.
  double evaluate(const CodewordCloud& source, const Eigen::Isometry3d& T_target_source);

  /// Correspondences of the last evaluation. Valid until the next one.
  const std::vector<CodewordPair>& correspondences() const { return pairs_; }

 private:
  const CodewordCloud& target_;
  ShrinkageRule rule_;
  double sigma_;
  float radius_ = 1;
  CodewordGrid grid_;
  std::vector<float> dissimilarity_;  // squared distance between codewords
  dependence::ShrunkInformation information_;
  std::vector<CodewordPair> pairs_;
};

}  // namespace infuse::registration
