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

/// One side of a dependence, prepared once and asked with many other sides: the particles of a
/// street map each bring their labels, the candidates of a calibration each bring their samples.
///
/// All that belongs to the prepared side alone is computed in the constructor, for every σ of the
/// grid and every fold of the cross-validation: kernel matrix, Gram matrix, its eigenvectors, its
/// held-out part in their coordinates. A question then costs the sums that join the two sides, and
/// for all λ of a grid one rotation.
///
/// The model is the product model I(2.7), whose coefficients solve P Θ A + λΘ = C:
///
/// | measure | P, prepared side | A, asked side | C |
/// |---|---|---|---|
/// | kSmi | mean ΦΦᵀ | mean ΦΦᵀ | mean Φ_P Φ_Aᵀ |
/// | kQmi | ∫ΦΦᵀ | ∫ΦΦᵀ | mean Φ_P Φ_Aᵀ − mean Φ_P · mean Φ_Aᵀ |
/// | kSce | mean ΦΦᵀ | ∫ΦΦᵀ | mean Φ_P Φ_Aᵀ |
///
/// Φ are Gaussian kernels at the centres (the same samples on both sides), for labels the delta
/// kernel at each label, which makes A diagonal. A fold is judged by ½⟨Θ, PΘA⟩ − ⟨Θ, C⟩ of what
/// was held out, I 2.2.2.2.
///
/// `ask` uses scratch memory of the object: one thread at a time. After a first question of the
/// same shape, labels are answered without allocating.
class PreparedDependence {
 public:
  /// `samples`: n × d, finite, not all alike. What is wrong with them or with the options is the
  /// reason of every answer.
  PreparedDependence(FitMeasure measure, const Samples& samples, const FitOptions& options);

  /// Static text: why no question can be answered; "" where all is well.
  const char* reason() const { return reason_; }

  /// Asks with one label 0 … label_count − 1 a sample. `kept` (its σ one of the grid's) leaves out
  /// the cross-validation.
  FitEstimate evaluate(std::span<const int32_t> labels, int label_count,
                       const std::optional<HyperParameters>& hyper_parameters = {});

  /// Asks with samples, n × d' for any d'. With `gradient` (kSmi only; it is left empty otherwise,
  /// and where the answer is not usable) also ∂value/∂samples, n × d', hyper-parameters held, the
  /// centres moving with their samples.
  FitEstimate evaluate(const Samples& samples,
                       const std::optional<HyperParameters>& hyper_parameters = {},
                       Eigen::MatrixXd* gradient = nullptr);

 private:
  /// The prepared side as one training set sees it.
  struct Split {
    SpectralBasis basis;  ///< of P
    Eigen::MatrixXd
        held_out_gram;  ///< P of the fold held out, rotated into the basis; of the whole: empty
  };
  /// The prepared side at one σ.
  struct Width {
    double sigma = 0;
    Eigen::MatrixXd features;   ///< Φ_P, centres × n, samples in order of fold
    std::vector<Split> splits;  ///< all but fold 0, all but fold 1, …, the whole
  };
  /// Sums over some samples that join the two sides.
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
  void sum_labels(const Width& width, int label_count);
  void sum_samples(const Width& width);
  void sum_folds();
  void subtract(const Sums& part, Sums& rest) const;
  void normalise_cross(const Sums& sums, Eigen::MatrixXd& out) const;
  void compute_moving_basis(const Sums& sums, TridiagonalBasis& out) const;
  void rotate(const Split& split, const TridiagonalBasis& moving, Eigen::MatrixXd& matrix);
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
  Folds folds_;                   ///< one fold where there is nothing to cross-validate
  std::vector<int> centre_rows_;  ///< centres, as places in folds_.order
  std::vector<Width> widths_;

  // Scratch of a question.
  std::vector<int> group_begin_, group_fill_, grouped_;  ///< samples by fold, then label
  Eigen::MatrixXd moving_samples_, moving_centres_, moving_features_;
  std::vector<Sums> fold_sums_;  ///< by fold
  Sums total_, train_;
  TridiagonalBasis moving_basis_;
  Eigen::MatrixXd cross_, held_out_cross_, held_out_gram_, rotated_, theta_, stack_, product_;
  std::vector<double> errors_;
};

}  // namespace infuse::dependence
