#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include "fusion/dependence/gaussian_kernel.hpp"
#include "fusion/dependence/least_squares.hpp"

namespace infuse::dependence {

/// Random numbers of the estimators: the same sequence for a seed on every machine.
using Random = std::mt19937_64;

/// Returns `count` different indices below `n`, ascending, all subsets equally likely; all indices
/// if count >= n.
std::vector<int> choose_subset(int n, int count, Random& random);

/// The same into `list`, whose memory is reused.
void choose_subset(int n, int count, Random& random, std::vector<int>& list);

/// Random assignment of samples to the folds of a cross-validation, of equal sizes to within one.
struct Folds {
  std::vector<int> order;  ///< samples in order of fold
  std::vector<int> begin;  ///< begin of each fold in `order`, and the end

  int count() const { return static_cast<int>(begin.size()) - 1; }
  int size(int fold) const {
    return begin[static_cast<size_t>(fold) + 1] - begin[static_cast<size_t>(fold)];
  }
};

/// Assigns n samples to `count` folds, 1 <= count <= n.
Folds make_folds(int n, int count, Random& random);

/// The same into `folds`, whose memory is reused.
void make_folds(int n, int count, Random& random, Folds& folds);

/// Returns why samples are unusable, as static text, "" if usable: too few, not finite (or beyond
/// 1e100), all equal.
const char* check_samples(const Samples& samples);

/// The same for samples to be fitted with `options`, which must be valid and leave every fold a
/// sample.
const char* check_samples(const Samples& samples, const FitOptions& options);

/// The same for the two sides of a dependence, which must have the same length.
const char* check_paired_samples(const Samples& x, const Samples& y);

/// The same for labels 0 … label_count − 1 of n samples; label_count is 1 … 10000.
const char* check_labels(std::span<const int32_t> labels, Eigen::Index n, int label_count);

/// Copies row rows[i] of `samples` to row i of `out`.
void gather_rows(const Samples& samples, const std::vector<int>& rows, Eigen::MatrixXd& out);

}  // namespace infuse::dependence
