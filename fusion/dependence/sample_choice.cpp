#include "fusion/dependence/sample_choice.hpp"

#include <algorithm>
#include <numeric>

namespace infuse::dependence {
namespace {

// Uniform integer below `bound`, by multiplication; the bias of bound/2^32 is negligible here.
int random_below(int bound, Random& random) {
  return static_cast<int>(((random() >> 32) * static_cast<uint64_t>(bound)) >> 32);
}

// Replaces the first `count` entries by a random draw without replacement.
void partial_shuffle(std::vector<int>& list, int count, Random& random) {
  const int n = static_cast<int>(list.size());
  for (int i = 0; i < count; ++i) {
    std::swap(list[static_cast<size_t>(i)],
              list[static_cast<size_t>(i + random_below(n - i, random))]);
  }
}

}  // namespace

void choose_subset(int n, int count, Random& random, std::vector<int>& list) {
  list.resize(static_cast<size_t>(n));
  std::iota(list.begin(), list.end(), 0);
  if (count >= n) return;
  partial_shuffle(list, count, random);
  list.resize(static_cast<size_t>(count));
  std::sort(list.begin(), list.end());
}

std::vector<int> choose_subset(int n, int count, Random& random) {
  std::vector<int> list;
  choose_subset(n, count, random, list);
  return list;
}

void make_folds(int n, int count, Random& random, Folds& folds) {
  folds.order.resize(static_cast<size_t>(n));
  std::iota(folds.order.begin(), folds.order.end(), 0);
  partial_shuffle(folds.order, n, random);
  folds.begin.clear();
  for (int f = 0; f <= count; ++f) {
    folds.begin.push_back(static_cast<int>(static_cast<int64_t>(n) * f / count));
  }
}

Folds make_folds(int n, int count, Random& random) {
  Folds folds;
  make_folds(n, count, random, folds);
  return folds;
}

const char* check_samples(const Samples& samples) {
  constexpr double kMaxMagnitude = 1e100;  // sums of squares do not overflow
  if (samples.rows() < 2 || samples.cols() < 1) return "fewer than two samples";
  bool varies = false;
  for (Eigen::Index f = 0; f < samples.cols(); ++f) {
    for (Eigen::Index i = 0; i < samples.rows(); ++i) {
      if (!(std::abs(samples(i, f)) <= kMaxMagnitude)) return "a sample is not finite";
      varies |= samples(i, f) != samples(0, f);
    }
  }
  return varies ? "" : "all samples are equal";
}

const char* check_samples(const Samples& samples, const FitOptions& options) {
  if (options.invalid()) return "invalid options";
  const char* reason = check_samples(samples);
  if (*reason != '\0') return reason;
  return samples.rows() < options.effective_folds() ? "fewer samples than folds" : "";
}

const char* check_paired_samples(const Samples& x, const Samples& y) {
  const char* reason = check_samples(x);
  if (*reason == '\0') reason = check_samples(y);
  if (*reason == '\0' && x.rows() != y.rows()) return "the two sides differ in length";
  return reason;
}

const char* check_labels(std::span<const int32_t> labels, Eigen::Index n, int label_count) {
  if (static_cast<Eigen::Index>(labels.size()) != n) return "the two sides differ in length";
  if (label_count < 1 || label_count > 10000) return "label_count is not between 1 and 10000";
  bool varies = false;
  for (const int32_t label : labels) {
    if (label < 0 || label >= label_count) return "a label is not between 0 and label_count − 1";
    varies |= label != labels[0];
  }
  return varies ? "" : "all labels are equal";
}

void gather_rows(const Samples& samples, const std::vector<int>& rows, Eigen::MatrixXd& out) {
  out.resize(static_cast<Eigen::Index>(rows.size()), samples.cols());
  for (Eigen::Index f = 0; f < samples.cols(); ++f) {
    for (Eigen::Index i = 0; i < out.rows(); ++i) {
      out(i, f) = samples(rows[static_cast<size_t>(i)], f);
    }
  }
}

}  // namespace infuse::dependence
