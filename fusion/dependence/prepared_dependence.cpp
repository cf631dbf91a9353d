#include "fusion/dependence/prepared_dependence.hpp"

#include <algorithm>
#include <cmath>

#include "fusion/dependence/column_sums.hpp"
#include "fusion/dependence/matrix_product.hpp"
#include "fusion/dependence/range_basis.hpp"
#include "fusion/dependence/sample_choice.hpp"
#include "fusion/dependence/smi_gradient.hpp"

namespace infuse::dependence {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

PreparedDependence::PreparedDependence(FitMeasure measure, const Samples& samples,
                                       const FitOptions& options)
    : measure_(measure), options_(options) {
  reason_ = check_samples(samples, options);
  if (*reason_ != '\0') return;
  const int n = static_cast<int>(samples.rows());
  Random random(options.seed);
  const std::vector<int> centres = choose_subset(n, options.centres, random);
  folds_ = make_folds(n, options.effective_folds(), random);
  std::vector<int> place(folds_.order.size());
  for (int i = 0; i < n; ++i) place[static_cast<size_t>(folds_.order[static_cast<size_t>(i)])] = i;
  for (const int centre : centres) centre_rows_.push_back(place[static_cast<size_t>(centre)]);

  MatrixXd ordered;
  gather_rows(samples, folds_.order, ordered);
  for (const double sigma : options.sigmas) prepare_width(sigma, ordered);
}

void PreparedDependence::prepare_width(double sigma, const Samples& ordered) {
  Width width;
  width.sigma = sigma;
  MatrixXd centres;
  gather_rows(ordered, centre_rows_, centres);
  gaussian_kernel(ordered, centres, sigma, width.features);

  MatrixXd total = MatrixXd::Zero(centres.rows(), centres.rows()), gram;
  for (int f = 0; f < folds_.count(); ++f) {
    multiply_by_transpose(
        width.features.middleCols(folds_.begin[static_cast<size_t>(f)], folds_.size(f)), gram);
    total += gram;
  }
  if (measure_ == FitMeasure::kQmi) {
    MatrixXd integral;
    gaussian_overlap(centres, sigma, integral);
    width.basis = spectral_basis(integral);
    prepare_splits(width, width.features, integral);
  } else {
    width.basis = spectral_basis(total / static_cast<double>(folds_.order.size()));
    multiply(range_basis(total), width.features, width.reduced);
    prepare_splits(width, width.reduced, {});
  }
  if (width.basis.rotation.size() == 0) reason_ = "the kernel matrix of the fixed side is singular";
  widths_.push_back(std::move(width));
}

// `integral` is P of every fold; empty: P is the Gram matrix of its features.
void PreparedDependence::prepare_splits(Width& width, const MatrixXd& features,
                                        const MatrixXd& integral) {
  const int folds = folds_.count();
  if (folds == 1) return;
  std::vector<MatrixXd> grams(static_cast<size_t>(folds));
  MatrixXd total = MatrixXd::Zero(features.rows(), features.rows());
  for (int f = 0; f < folds && integral.size() == 0; ++f) {
    const auto fold = static_cast<size_t>(f);
    multiply_by_transpose(features.middleCols(folds_.begin[fold], folds_.size(f)), grams[fold]);
    total += grams[fold];
  }
  const double n = static_cast<double>(folds_.order.size());
  for (int f = 0; f < folds; ++f) {
    const auto fold = static_cast<size_t>(f);
    const double count = folds_.size(f);
    Split& split = width.splits.emplace_back();
    split.basis = integral.size() != 0
                      ? width.basis
                      : spectral_basis(MatrixXd((total - grams[fold]) / (n - count)));
    if (split.basis.rotation.size() == 0) {
      width.basis = {};
      return;
    }
    MatrixXd half;
    multiply(split.basis.rotation, integral.size() != 0 ? integral : MatrixXd(grams[fold] / count),
             half);
    multiply(half, split.basis.rotation.transpose(), split.held_out_gram);
  }
}

const PreparedDependence::Width* PreparedDependence::find_width(double sigma) const {
  for (const Width& width : widths_) {
    if (width.sigma == sigma) return &width;
  }
  return nullptr;
}

// --- the two kinds of evaluation ---

FitEstimate PreparedDependence::evaluate(std::span<const int32_t> labels, int label_count,
                                         const std::optional<HyperParameters>& hyper_parameters) {
  FitEstimate answer;
  answer.reason = reason_;
  if (answer.usable()) {
    answer.reason = check_labels(labels, static_cast<Index>(folds_.order.size()), label_count);
  }
  if (!answer.usable()) return answer;
  group_labels(labels, label_count);
  return fit([&](const Width&, const MatrixXd& features) { sum_labels(features, label_count); },
             hyper_parameters);
}

FitEstimate PreparedDependence::evaluate(const Samples& samples,
                                         const std::optional<HyperParameters>& hyper_parameters,
                                         MatrixXd* gradient) {
  FitEstimate answer;
  if (gradient != nullptr) gradient->resize(0, 0);
  answer.reason = *reason_ != '\0' ? reason_ : check_samples(samples);
  if (answer.usable() && samples.rows() != static_cast<Index>(folds_.order.size())) {
    answer.reason = "the two sides differ in length";
  }
  if (!answer.usable()) return answer;
  gather_rows(samples, folds_.order, moving_samples_);
  gather_rows(moving_samples_, centre_rows_, moving_centres_);
  answer = fit([&](const Width& width, const MatrixXd& features) { sum_samples(width, features); },
               hyper_parameters);
  if (gradient == nullptr || measure_ != FitMeasure::kSmi || !answer.usable()) return answer;

  const Width& width = *find_width(answer.hyper_parameters.sigma);
  MatrixXd sensitivity, ordered;
  smi_sensitivity(
      {width.basis, moving_basis_, theta_, answer.hyper_parameters.lambda, options_.form},
      width.features, moving_features_, sensitivity);
  gaussian_kernel_gradient(moving_samples_, centre_rows_, width.sigma, moving_features_,
                           sensitivity, ordered);
  gradient->resize(samples.rows(), samples.cols());
  for (Index i = 0; i < ordered.rows(); ++i) {
    gradient->row(folds_.order[static_cast<size_t>(i)]) = ordered.row(i);
  }
  return answer;
}

// --- sums over both sides ---

// Sorts the samples by fold, then label, by counting.
void PreparedDependence::group_labels(std::span<const int32_t> labels, int label_count) {
  const auto count = static_cast<size_t>(label_count);
  const auto group_of = [&](size_t fold, int place) {
    const int row = folds_.order[static_cast<size_t>(place)];
    return fold * count + static_cast<size_t>(labels[static_cast<size_t>(row)]);
  };
  const auto folds = static_cast<size_t>(folds_.count());
  group_begin_.assign(folds * count + 1, 0);
  for (size_t f = 0; f < folds; ++f) {
    for (int i = folds_.begin[f]; i < folds_.begin[f + 1]; ++i) ++group_begin_[group_of(f, i) + 1];
  }
  for (size_t g = 1; g < group_begin_.size(); ++g) group_begin_[g] += group_begin_[g - 1];
  group_fill_.assign(group_begin_.begin(), group_begin_.end());
  grouped_.resize(folds_.order.size());
  for (size_t f = 0; f < folds; ++f) {
    for (int i = folds_.begin[f]; i < folds_.begin[f + 1]; ++i) {
      grouped_[static_cast<size_t>(group_fill_[group_of(f, i)]++)] = i;
    }
  }
}

void PreparedDependence::sum_labels(const MatrixXd& features, int label_count) {
  fold_sums_.resize(static_cast<size_t>(folds_.count()));
  for (size_t f = 0; f < fold_sums_.size(); ++f) {
    Sums& sums = fold_sums_[f];
    sums.n = folds_.size(static_cast<int>(f));
    sums.cross.resize(features.rows(), label_count);
    sums.gram.resize(0, 0);
    sums.gram_diagonal.resize(label_count);
    for (int label = 0; label < label_count; ++label) {
      const size_t group = f * static_cast<size_t>(label_count) + static_cast<size_t>(label);
      const auto begin = static_cast<size_t>(group_begin_[group]);
      const size_t count = static_cast<size_t>(group_begin_[group + 1]) - begin;
      sum_columns(features, std::span(grouped_).subspan(begin, count),
                  sums.cross.data() + label * sums.cross.rows());
      sums.gram_diagonal[label] = static_cast<double>(count);
    }
    if (measure_ == FitMeasure::kQmi) {
      sums.fixed = sums.cross.rowwise().sum();
      sums.moving = sums.gram_diagonal;
    }
    if (measure_ != FitMeasure::kSmi) sums.gram_diagonal.setOnes();
  }
  sum_folds();
}

void PreparedDependence::sum_samples(const Width& width, const MatrixXd& features) {
  gaussian_kernel(moving_samples_, moving_centres_, width.sigma, moving_features_);
  const bool reduce = measure_ == FitMeasure::kSmi && &features == &width.reduced;
  if (reduce) {
    MatrixXd gram;
    multiply_by_transpose(moving_features_, gram);
    multiply(range_basis(gram), moving_features_, moving_reduced_);
  }
  const MatrixXd& moving_features = reduce ? moving_reduced_ : moving_features_;
  fold_sums_.resize(static_cast<size_t>(folds_.count()));
  for (size_t f = 0; f < fold_sums_.size(); ++f) {
    Sums& sums = fold_sums_[f];
    const int count = folds_.size(static_cast<int>(f));
    const auto fixed = features.middleCols(folds_.begin[f], count);
    const auto moving = moving_features.middleCols(folds_.begin[f], count);
    sums.n = count;
    multiply(fixed, moving.transpose(), sums.cross);
    if (measure_ == FitMeasure::kSmi) {
      multiply_by_transpose(moving, sums.gram);
    } else {
      gaussian_overlap(moving_centres_, width.sigma, sums.gram);
    }
    if (measure_ == FitMeasure::kQmi) {
      sums.fixed = fixed.rowwise().sum();
      sums.moving = moving.rowwise().sum();
    }
  }
  sum_folds();
}

void PreparedDependence::sum_folds() {
  total_ = fold_sums_[0];
  for (size_t f = 1; f < fold_sums_.size(); ++f) {
    total_.n += fold_sums_[f].n;
    total_.cross += fold_sums_[f].cross;
    if (measure_ == FitMeasure::kQmi) {
      total_.fixed += fold_sums_[f].fixed;
      total_.moving += fold_sums_[f].moving;
    }
    if (measure_ == FitMeasure::kSmi) {
      total_.gram += fold_sums_[f].gram;
      total_.gram_diagonal += fold_sums_[f].gram_diagonal;
    }
  }
}

void PreparedDependence::subtract(const Sums& part, Sums& rest) const {
  rest.n = total_.n - part.n;
  rest.cross = total_.cross - part.cross;
  if (measure_ == FitMeasure::kQmi) {
    rest.fixed = total_.fixed - part.fixed;
    rest.moving = total_.moving - part.moving;
  }
  if (measure_ == FitMeasure::kSmi) {
    rest.gram = total_.gram - part.gram;
    rest.gram_diagonal = total_.gram_diagonal - part.gram_diagonal;
  } else {
    rest.gram = total_.gram;
    rest.gram_diagonal = total_.gram_diagonal;
  }
}

// --- the fit ---

void PreparedDependence::normalise_cross(const Sums& sums, MatrixXd& out) const {
  out = sums.cross / sums.n;
  if (measure_ != FitMeasure::kQmi) return;
  for (Index c = 0; c < out.cols(); ++c) {
    out.col(c) -= sums.fixed * (sums.moving[c] / (sums.n * sums.n));
  }
}

void PreparedDependence::compute_moving_basis(const Sums& sums, TridiagonalBasis& out) const {
  const double n = measure_ == FitMeasure::kSmi ? sums.n : 1.0;
  if (sums.gram.size() != 0) {
    out = tridiagonal_basis(sums.gram / n);
    return;
  }
  out.rotation.resize(0, 0);
  out.subdiagonal.resize(0);
  out.diagonal = sums.gram_diagonal / n;
}

// Computes matrix = rotation of the prepared side · matrix · (rotation of the other side)ᵀ.
void PreparedDependence::rotate(const SpectralBasis& fixed, const TridiagonalBasis& moving,
                                MatrixXd& matrix) {
  multiply(fixed.rotation, matrix, rotated_);
  if (moving.rotation.size() == 0) {
    matrix = rotated_;
  } else {
    multiply(rotated_, moving.rotation.transpose(), matrix);
  }
}

void PreparedDependence::add_fold_errors(const Split& split, const Sums& held_out,
                                         std::span<double> errors) {
  subtract(held_out, train_);
  compute_moving_basis(train_, moving_basis_);
  normalise_cross(train_, cross_);
  rotate(split.basis, moving_basis_, cross_);
  normalise_cross(held_out, held_out_cross_);
  rotate(split.basis, moving_basis_, held_out_cross_);
  const bool diagonal = held_out.gram.size() == 0;
  const double n = measure_ == FitMeasure::kSmi ? held_out.n : 1.0;
  if (!diagonal) {
    held_out_gram_ = held_out.gram / n;
    multiply(moving_basis_.rotation, held_out_gram_, rotated_);
    multiply(rotated_, moving_basis_.rotation.transpose(), held_out_gram_);
  }
  // The solutions of all λ are side by side, so that one product with P serves them all.
  const Index rows = cross_.rows(), columns = cross_.cols();
  stack_.resize(rows, columns * static_cast<Index>(errors.size()));
  for (size_t k = 0; k < errors.size(); ++k) {
    solve_sylvester(split.basis.eigenvalues, moving_basis_, options_.lambdas[k], cross_, theta_);
    stack_.middleCols(static_cast<Index>(k) * columns, columns) = theta_;
  }
  multiply(split.held_out_gram, stack_, product_);
  for (size_t k = 0; k < errors.size(); ++k) {
    const Index first = static_cast<Index>(k) * columns;
    const auto theta = stack_.middleCols(first, columns);
    double quadratic = 0;
    if (diagonal) {
      for (Index c = 0; c < columns; ++c) {
        quadratic += held_out.gram_diagonal[c] / n * theta.col(c).dot(product_.col(first + c));
      }
    } else {
      multiply(product_.middleCols(first, columns), held_out_gram_, rotated_);
      quadratic = theta.cwiseProduct(rotated_).sum();
    }
    errors[k] += 0.5 * quadratic - theta.cwiseProduct(held_out_cross_).sum();
  }
}

template <class ComputeSums>
std::optional<HyperParameters> PreparedDependence::cross_validate(const ComputeSums& compute_sums) {
  if (folds_.count() == 1) return HyperParameters{options_.sigmas[0], options_.lambdas[0]};
  std::optional<HyperParameters> best;
  double best_error = std::numeric_limits<double>::max();
  errors_.resize(options_.lambdas.size());
  for (const Width& width : widths_) {
    compute_sums(width, width.reduced.size() != 0 ? width.reduced : width.features);
    std::fill(errors_.begin(), errors_.end(), 0.0);
    for (size_t f = 0; f < fold_sums_.size(); ++f)
      add_fold_errors(width.splits[f], fold_sums_[f], errors_);
    for (size_t k = 0; k < errors_.size(); ++k) {
      if (!(errors_[k] < best_error)) continue;
      best_error = errors_[k];
      best = HyperParameters{width.sigma, options_.lambdas[k]};
    }
  }
  return best;
}

template <class ComputeSums>
FitEstimate PreparedDependence::fit(const ComputeSums& compute_sums,
                                    const std::optional<HyperParameters>& hyper_parameters) {
  FitEstimate answer;
  const auto chosen = hyper_parameters ? hyper_parameters : cross_validate(compute_sums);
  const Width* width = chosen ? find_width(chosen->sigma) : nullptr;
  if (!chosen) {
    answer.reason = "no hyper-parameters of the grid give a finite fit";
  } else if (width == nullptr) {
    answer.reason = "the given sigma is not in the grid";
  } else if (!(chosen->lambda >= 1e-12 && chosen->lambda <= 1e12)) {
    answer.reason = "the given lambda is not between 1e-12 and 1e12";
  }
  if (!answer.usable()) return answer;
  answer.hyper_parameters = *chosen;

  compute_sums(*width, width->features);
  compute_moving_basis(total_, moving_basis_);
  normalise_cross(total_, cross_);
  rotate(width->basis, moving_basis_, cross_);
  solve_sylvester(width->basis.eigenvalues, moving_basis_, chosen->lambda, cross_, theta_);
  const double linear = theta_.cwiseProduct(cross_).sum();  // ⟨Θ, C⟩
  const double ridge = chosen->lambda * theta_.squaredNorm();  // ⟨Θ, PΘA⟩ = ⟨Θ, C⟩ − λ|Θ|²
  switch (measure_) {
    case FitMeasure::kSmi:
      answer.value = 0.5 * linear - 0.5;
      if (options_.form == SmiForm::kPlugIn) answer.value += 0.5 * ridge;
      break;
    case FitMeasure::kQmi:
      answer.value = linear + ridge;  // 2⟨Θ, C⟩ − ⟨Θ, PΘA⟩
      break;
    case FitMeasure::kSce:
      answer.value = -0.5 * (linear + ridge);  // ½⟨Θ, PΘA⟩ − ⟨Θ, C⟩
      break;
  }
  if (!std::isfinite(answer.value)) {
    answer.value = 0;
    answer.reason = "the kernel matrices are singular at this lambda";
  }
  return answer;
}

}  // namespace infuse::dependence
