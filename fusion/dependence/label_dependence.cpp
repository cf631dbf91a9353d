#include "fusion/dependence/label_dependence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "fusion/dependence/column_sums.hpp"
#include "fusion/dependence/matrix_product.hpp"

namespace infuse::dependence {

using Eigen::Index;
using Eigen::MatrixXd;

LabelDependence::LabelDependence(const FitOptions& options) : options_(options) {
  if (options.invalid()) return;
  widths_.resize(options.sigmas.size());
  errors_.resize(options.lambdas.size());
}

void LabelDependence::reserve(int samples, int features, int labels) {
  const auto n = static_cast<size_t>(samples), k = static_cast<size_t>(labels);
  const size_t centres = std::min(n, static_cast<size_t>(options_.centres));
  const auto folds = static_cast<size_t>(options_.folds);
  for (std::vector<int>* list : {&folds_.order, &centres_, &row_indices_, &grouped_})
    list->reserve(n);
  for (std::vector<int>* list : {&group_begin_, &group_fill_}) list->reserve(folds * k + 1);
  folds_.begin.reserve(folds + 1);
  ordered_.reserve(n * static_cast<size_t>(features));
  for (Width& width : widths_) width.features.reserve(n * centres);
  cross_.reserve(folds * centres * k);
  label_shares_.reserve(k);
  for (auto* list :
       {&total_, &rotated_columns_, &rotated_, &held_out_cross_, &ratio_, &pivot_, &theta_}) {
    list->reserve(centres * k);
  }
  for (auto* list : {&stack_, &product_}) list->reserve(centres * k * options_.lambdas.size());
}

void LabelDependence::prepare(const Samples& samples) {
  reason_ = check_samples(samples, options_);
  if (*reason_ != '\0') return;
  const auto n = static_cast<int>(samples.rows());
  Random random(options_.seed);
  choose_subset(n, options_.centres, random, centres_);
  make_folds(n, options_.effective_folds(), random, folds_);
  b_ = centres_.size();
  row_indices_.resize(static_cast<size_t>(n));
  std::iota(row_indices_.begin(), row_indices_.end(), 0);
  gather_rows(samples, centres_, centre_samples_);
  ordered_.resize(static_cast<size_t>(samples.size()));
  for (Index f = 0; f < samples.cols(); ++f) {
    double* column = ordered_.data() + f * n;
    for (int i = 0; i < n; ++i) column[i] = samples(folds_.order[static_cast<size_t>(i)], f);
  }
  for (size_t w = 0; w < widths_.size(); ++w) {
    widths_[w].sigma = options_.sigmas[w];
    prepare_width(widths_[w], samples.cols());
  }
}

void LabelDependence::prepare_width(Width& width, Index dimensions) {
  const auto n = static_cast<Index>(folds_.order.size()), b = static_cast<Index>(b_);
  const auto parts = static_cast<size_t>(folds_.count());
  width.features.resize(b_ * folds_.order.size());
  gaussian_kernel(Eigen::Map<const MatrixXd>(ordered_.data(), n, dimensions), centre_samples_,
                  width.sigma, width.features.data());
  width.sums.resize(parts);
  width.grams.resize(parts);
  width.gram.setZero(b, b);
  width.sum.setZero(b);
  for (size_t f = 0; f < parts; ++f) {
    const int begin = folds_.begin[f], count = folds_.size(static_cast<int>(f));
    const Eigen::Map<const MatrixXd> part(width.features.data() + b * begin, b, count);
    multiply_by_transpose(part, width.grams[f]);
    width.sums[f].resize(b);
    sum_columns(
        width.features.data(), b,
        std::span(row_indices_).subspan(static_cast<size_t>(begin), static_cast<size_t>(count)),
        width.sums[f].data());
    width.gram += width.grams[f];
    width.sum += width.sums[f];
  }
  train_ = width.gram / static_cast<double>(n);
  compute_basis(width.basis);
  if (parts == 1) return;
  width.bases.resize(parts);
  width.held_out_grams.resize(parts);
  for (size_t f = 0; f < parts; ++f) {
    const double held_out = folds_.size(static_cast<int>(f));
    train_ = (width.gram - width.grams[f]) / (static_cast<double>(n) - held_out);
    compute_basis(width.bases[f]);
    multiply(width.grams[f], width.bases[f].rotation.transpose(), half_);
    multiply(width.bases[f].rotation, half_, width.held_out_grams[f]);
    width.held_out_grams[f] /= held_out;
  }
}

/// Computes the basis of `train_`.
void LabelDependence::compute_basis(Basis& basis) {
  const Index b = train_.rows();
  if (b == 1) {
    basis.rotation.setOnes(1, 1);
    basis.diagonal = train_.diagonal();
    return;
  }
  reduction_.compute(train_);
  basis.rotation.resize(b, b);
  workspace_.resize(b);
  reduction_.matrixQ().evalTo(basis.rotation, workspace_);
  basis.rotation.transposeInPlace();
  basis.diagonal = reduction_.diagonal();
  basis.subdiagonal = reduction_.subDiagonal();
}

// --- sums over both sides ---

// Sorts the samples by fold, then by label, by counting; one fold is the whole set.
void LabelDependence::group_labels(std::span<const int32_t> labels, size_t parts) {
  const auto n = static_cast<int>(folds_.order.size());
  const auto end_of = [&](size_t part) { return parts == 1 ? n : folds_.begin[part + 1]; };
  const auto label_at = [&](int place) {
    return static_cast<size_t>(
        labels[static_cast<size_t>(folds_.order[static_cast<size_t>(place)])]);
  };
  group_begin_.assign(parts * k_ + 1, 0);
  grouped_.resize(folds_.order.size());
  int at = 0;
  for (size_t part = 0; part < parts; ++part) {
    for (; at < end_of(part); ++at) ++group_begin_[part * k_ + label_at(at) + 1];
  }
  for (size_t g = 1; g < group_begin_.size(); ++g) group_begin_[g] += group_begin_[g - 1];
  group_fill_.assign(group_begin_.begin(), group_begin_.end());
  at = 0;
  for (size_t part = 0; part < parts; ++part) {
    for (; at < end_of(part); ++at) {
      grouped_[static_cast<size_t>(group_fill_[part * k_ + label_at(at)]++)] = at;
    }
  }
}

// cross = Σ Φ by label, centres × labels, of a fold whose sum over all labels is `sum`.
void LabelDependence::sum_labels(const Width& width, size_t part, std::span<const double> sum,
                                 double* cross) {
  const auto size_of = [&](size_t label) {
    return group_begin_[part * k_ + label + 1] - group_begin_[part * k_ + label];
  };
  size_t largest = 0;
  for (size_t k = 1; k < k_; ++k) largest = size_of(k) > size_of(largest) ? k : largest;
  double* rest = cross + largest * b_;
  std::copy(sum.begin(), sum.end(), rest);
  for (size_t k = 0; k < k_; ++k) {
    if (k == largest) continue;
    double* out = cross + k * b_;
    const auto first = static_cast<size_t>(group_begin_[part * k_ + k]);
    sum_columns(width.features.data(), static_cast<Index>(b_),
                std::span(grouped_).subspan(first, static_cast<size_t>(size_of(k))), out);
    for (size_t l = 0; l < b_; ++l) rest[l] -= out[l];
  }
}

// --- the fit ---

// out = scale · (rotation · cross)ᵀ, labels × centres.
void LabelDependence::rotate(const double* cross, const Basis& basis, double scale,
                             std::vector<double>& out) {
  const auto b = static_cast<Index>(b_), k = static_cast<Index>(k_);
  out.resize(b_ * k_);
  rotated_columns_.resize(b_ * k_);
  multiply(matrix_view(basis.rotation), {cross, b, k, 1, b}, rotated_columns_.data(), b,
           best_instruction_set());
  for (size_t i = 0; i < b_; ++i) {
    for (size_t l = 0; l < k_; ++l) out[i * k_ + l] = scale * rotated_columns_[l * b_ + i];
  }
}

// Gaussian elimination without pivoting of (share_[k] T + λ) θ_k = right_k, for all labels at once:
// the matrices are positive definite. Leaves the right side in `theta_`.
void LabelDependence::eliminate(const Basis& basis, double lambda,
                                const std::vector<double>& right) {
  ratio_.resize(b_ * k_);
  pivot_.resize(b_ * k_);
  theta_.resize(b_ * k_);
  for (size_t i = 0; i < b_; ++i) {
    const double d = basis.diagonal[static_cast<Index>(i)];
    const double e = i > 0 ? basis.subdiagonal[static_cast<Index>(i) - 1] : 0;
    double *ratio = ratio_.data() + i * k_, *pivot = pivot_.data() + i * k_;
    double* theta = theta_.data() + i * k_;
    const double* c = right.data() + i * k_;
    if (i == 0) {
      for (size_t k = 0; k < k_; ++k) {
        pivot[k] = label_shares_[k] * d + lambda;
        theta[k] = c[k];
      }
      continue;
    }
    const double *before = pivot - k_, *above = theta - k_;
    for (size_t k = 0; k < k_; ++k) {
      ratio[k] = label_shares_[k] * e / before[k];
      pivot[k] = label_shares_[k] * d + lambda - label_shares_[k] * e * ratio[k];
      theta[k] = c[k] - ratio[k] * above[k];
    }
  }
}

// ½ Σ c_kᵀ (a_k P + λ)⁻¹ c_k − ½, from the forward elimination alone.
double LabelDependence::compute_value(const Width& width, double lambda) {
  const auto n = static_cast<double>(folds_.order.size());
  for (size_t k = 0; k < k_; ++k) label_shares_[k] = (group_begin_[k + 1] - group_begin_[k]) / n;
  rotate(cross_.data(), width.basis, 1 / n, rotated_);
  eliminate(width.basis, lambda, rotated_);
  double sum = 0;
  for (size_t i = 0; i < theta_.size(); ++i) sum += theta_[i] * theta_[i] / pivot_[i];
  return 0.5 * sum - 0.5;
}

// Criterion I 2.2.2.2 of one held-out fold, for each λ.
void LabelDependence::add_fold_errors(const Width& width, size_t fold) {
  const Basis& basis = width.bases[fold];
  const double held_out = folds_.size(static_cast<int>(fold));
  const double rest = static_cast<double>(folds_.order.size()) - held_out;
  const double* part = cross_.data() + fold * b_ * k_;
  rotate(part, basis, 1 / held_out, held_out_cross_);
  rotate(total_.data(), basis, 1 / rest, rotated_);
  for (size_t i = 0; i < rotated_.size(); ++i) rotated_[i] -= held_out / rest * held_out_cross_[i];
  const auto size_of = [&](size_t part_at, size_t label) {
    return static_cast<double>(group_begin_[part_at * k_ + label + 1] -
                               group_begin_[part_at * k_ + label]);
  };
  for (size_t k = 0; k < k_; ++k) {
    double count = 0;
    for (size_t f = 0; f < static_cast<size_t>(folds_.count()); ++f) count += size_of(f, k);
    label_shares_[k] = (count - size_of(fold, k)) / rest;
  }
  // The solutions of all λ are stacked, so that one product with P serves them all.
  const size_t lambdas = options_.lambdas.size(), rows = lambdas * k_;
  stack_.resize(b_ * rows);
  product_.resize(b_ * rows);
  for (size_t l = 0; l < lambdas; ++l) {
    eliminate(basis, options_.lambdas[l], rotated_);
    for (size_t i = b_; i-- > 0;) {
      const double *pivot = pivot_.data() + i * k_, *right = theta_.data() + i * k_;
      double* theta = stack_.data() + i * rows + l * k_;
      for (size_t k = 0; k < k_; ++k) theta[k] = right[k] / pivot[k];
      if (i + 1 == b_) continue;
      const double *ratio = ratio_.data() + (i + 1) * k_, *below = theta + rows;
      for (size_t k = 0; k < k_; ++k) theta[k] -= ratio[k] * below[k];
    }
  }
  multiply({stack_.data(), static_cast<Index>(rows), static_cast<Index>(b_), 1,
            static_cast<Index>(rows)},
           matrix_view(width.held_out_grams[fold]), product_.data(), static_cast<Index>(rows),
           best_instruction_set());
  for (size_t l = 0; l < lambdas; ++l) {
    double error = 0;
    for (size_t i = 0; i < b_; ++i) {
      const size_t first = i * rows + l * k_;
      for (size_t k = 0; k < k_; ++k) {
        const double theta = stack_[first + k];
        error += theta * (0.5 * size_of(fold, k) / held_out * product_[first + k] -
                          held_out_cross_[i * k_ + k]);
      }
    }
    errors_[l] += error;
  }
}

// Cross-validation over the grid; the samples are grouped by fold.
std::optional<HyperParameters> LabelDependence::cross_validate() {
  const auto parts = static_cast<size_t>(folds_.count());
  std::optional<HyperParameters> best;
  double best_error = std::numeric_limits<double>::max();
  cross_.resize(parts * b_ * k_);
  total_.resize(b_ * k_);
  for (const Width& width : widths_) {
    std::fill(total_.begin(), total_.end(), 0.0);
    for (size_t f = 0; f < parts; ++f) {
      double* part = cross_.data() + f * b_ * k_;
      sum_labels(width, f, {width.sums[f].data(), b_}, part);
      for (size_t i = 0; i < total_.size(); ++i) total_[i] += part[i];
    }
    std::fill(errors_.begin(), errors_.end(), 0.0);
    for (size_t f = 0; f < parts; ++f) add_fold_errors(width, f);
    for (size_t l = 0; l < errors_.size(); ++l) {
      if (!(errors_[l] < best_error)) continue;
      best_error = errors_[l];
      best = HyperParameters{width.sigma, options_.lambdas[l]};
    }
  }
  return best;
}

FitEstimate LabelDependence::evaluate(std::span<const int32_t> labels, int label_count,
                                      const std::optional<HyperParameters>& hyper_parameters) {
  FitEstimate answer;
  answer.reason = reason_;
  if (!answer.usable()) return answer;
  answer.reason = check_labels(labels, static_cast<Index>(folds_.order.size()), label_count);
  if (!answer.usable()) return answer;
  k_ = static_cast<size_t>(label_count);
  label_shares_.resize(k_);
  const auto parts = static_cast<size_t>(folds_.count());
  std::optional<HyperParameters> chosen = hyper_parameters;
  if (!hyper_parameters && parts == 1)
    chosen = HyperParameters{options_.sigmas[0], options_.lambdas[0]};
  if (!chosen) {
    group_labels(labels, parts);
    chosen = cross_validate();
  }
  const auto width = std::find_if(widths_.begin(), widths_.end(), [&](const Width& w) {
    return chosen && w.sigma == chosen->sigma;
  });
  if (!chosen) {
    answer.reason = "no hyper-parameters of the grid give a finite fit";
  } else if (width == widths_.end()) {
    answer.reason = "the given sigma is not in the grid";
  } else if (!(chosen->lambda >= 1e-12 && chosen->lambda <= 1e12)) {
    answer.reason = "the given lambda is not between 1e-12 and 1e12";
  }
  if (!answer.usable()) return answer;
  answer.hyper_parameters = *chosen;
  group_labels(labels, 1);
  cross_.resize(std::max(cross_.size(), b_ * k_));
  sum_labels(*width, 0, {width->sum.data(), b_}, cross_.data());
  answer.value = compute_value(*width, chosen->lambda);
  if (!std::isfinite(answer.value)) {
    answer.value = 0;
    answer.reason = "the kernel matrices are singular at this lambda";
  }
  return answer;
}

}  // namespace infuse::dependence
