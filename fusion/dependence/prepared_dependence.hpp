#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "fusion/dependence/gaussian_kernel.hpp"
#include "fusion/dependence/least_squares.hpp"
#include "fusion/dependence/sample_choice.hpp"
#include "fusion/dependence/sylvester.hpp"

namespace infuse::dependence {

/// One side of a dependence, prepared once and evaluated with many other sides: the labels of each
/// particle on a street map, or the samples of each candidate calibration.
///
/// The constructor computes all that depends on the prepared side alone, for every σ of the grid
/// and every fold of the cross-validation: kernel matrix, Gram matrix, its eigenvectors, and its
/// held-out part in their coordinates. An evaluation then costs the sums over both sides, and one
/// rotation for all λ of the grid. The cross-validation works in the ranges of the Gram matrices
/// (`range_basis`), where the folds lie too, with coordinates far fewer than centres for few
/// dimensions; the fit at the chosen σ and λ works with all centres.
///
/// The model is the product model I(2.7), whose coefficients solve P Θ A + λΘ = C:
///
/// | measure | P, prepared side | A, other side | C |
/// |---|---|---|---|
/// | kSmi | mean ΦΦᵀ | mean ΦΦᵀ | mean Φ_P Φ_Aᵀ |
/// | kQmi | ∫ΦΦᵀ | ∫ΦΦᵀ | mean Φ_P Φ_Aᵀ − mean Φ_P · mean Φ_Aᵀ |
/// | kSce | mean ΦΦᵀ | ∫ΦΦᵀ | mean Φ_P Φ_Aᵀ |
///
/// Φ are Gaussian kernels at the centres (the same samples on both sides); for labels, the delta
/// kernel at each label, which makes A diagonal. The error of a held-out fold is its ½⟨Θ, PΘA⟩ −
/// ⟨Θ, C⟩, I 2.2.2.2.
///
/// Single-threaded: `evaluate` uses scratch memory of the object. Labels are evaluated without
/// allocation after a first evaluation of the same shape.
class PreparedDependence {
 public:
  /// `samples`: n × d, finite, not all equal. Invalid samples or options become the reason of every
  /// estimate.
  PreparedDependence(FitMeasure measure, const Samples& samples, const FitOptions& options);

  /// Static text: why nothing can be evaluated; "" if it can.
  const char* reason() const { return reason_; }

  /// Evaluates one label 0 … label_count − 1 per sample. With `hyper_parameters` (σ in the grid)
  /// there is no cross-validation.
  FitEstimate evaluate(std::span<const int32_t> labels, int label_count,
                       const std::optional<HyperParameters>& hyper_parameters = {});

  /// Evaluates samples, n × d' for any d'. If `gradient` is given, sets it to ∂value/∂samples, n ×
  /// d', with fixed hyper-parameters and centres that move with their samples (kSmi only; empty for
  /// other measures and if the estimate is unusable).
  FitEstimate evaluate(const Samples& samples,
                       const std::optional<HyperParameters>& hyper_parameters = {},
                       Eigen::MatrixXd* gradient = nullptr);

 private:
  /// Prepared side of one fold.
  struct Split {
    SpectralBasis basis;            ///< of P of all other folds
    Eigen::MatrixXd held_out_gram;  ///< P of the fold, rotated into the basis
  };
  /// Prepared side at one σ.
  struct Width {
    double sigma = 0;
    Eigen::MatrixXd features;  ///< Φ_P, centres × n, samples in order of fold
    SpectralBasis basis;       ///< of P of the whole set
    Eigen::MatrixXd reduced;  ///< Φ_P in its range, rank × n; empty: the splits are of `features`
    std::vector<Split> splits;  ///< by fold
  };
  /// Sums over samples of both sides.
  struct Sums {
    double n = 0;
    Eigen::MatrixXd cross;          ///< Σ Φ_P Φ_Aᵀ
    Eigen::VectorXd fixed;          ///< Σ Φ_P; kQmi only
    Eigen::VectorXd moving;         ///< Σ Φ_A; kQmi only
    Eigen::MatrixXd gram;           ///< Σ Φ_A Φ_Aᵀ, or the integral; empty for labels
    Eigen::VectorXd gram_diagonal;  ///< the same for labels
  };

  void prepare_width(double sigma, const Samples& ordered);
  void group_labels(std::span<const int32_t> labels, int label_count);
  void prepare_splits(Width& width, const Eigen::MatrixXd& features,
                      const Eigen::MatrixXd& integral);
  void sum_labels(const Eigen::MatrixXd& features, int label_count);
  void sum_samples(const Width& width, const Eigen::MatrixXd& features);
  void sum_folds();
  void subtract(const Sums& part, Sums& rest) const;
  void normalise_cross(const Sums& sums, Eigen::MatrixXd& out) const;
  void compute_moving_basis(const Sums& sums, TridiagonalBasis& out) const;
  void rotate(const SpectralBasis& fixed, const TridiagonalBasis& moving, Eigen::MatrixXd& matrix);
  void add_fold_errors(const Split& split, const Sums& held_out, std::span<double> errors);
  template <class ComputeSums>
  FitEstimate fit(const ComputeSums& compute_sums,
                  const std::optional<HyperParameters>& hyper_parameters);
  template <class ComputeSums>
  std::optional<HyperParameters> cross_validate(const ComputeSums& compute_sums);
  const Width* find_width(double sigma) const;

  FitMeasure measure_;
  FitOptions options_;
  const char* reason_ = "";
  Folds folds_;                   ///< one fold if there is nothing to cross-validate
  std::vector<int> centre_rows_;  ///< centres, as indices into folds_.order
  std::vector<Width> widths_;

  // Scratch of an evaluation.
  std::vector<int> group_begin_, group_fill_, grouped_;  ///< samples by fold, then label
  Eigen::MatrixXd moving_samples_, moving_centres_, moving_features_, moving_reduced_;
  std::vector<Sums> fold_sums_;  ///< per fold
  Sums total_, train_;
  TridiagonalBasis moving_basis_;
  Eigen::MatrixXd cross_, held_out_cross_, held_out_gram_, rotated_, theta_, stack_, product_;
  std::vector<double> errors_;
};

}  // namespace infuse::dependence
