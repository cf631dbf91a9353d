#pragma once

#include <Eigen/Eigenvalues>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "fusion/dependence/gaussian_kernel.hpp"
#include "fusion/dependence/least_squares.hpp"
#include "fusion/dependence/sample_choice.hpp"

namespace infuse::dependence {

/// SMI between samples and labels by LSMI I(2.7–2.8), for a sequence of sample sets, each evaluated
/// with many labellings (the particles on a street map). Gives the same values as
/// `PreparedDependence` in half the time, and keeps its memory from set to set.
///
/// With the delta kernel of labels the model separates into one system per label, (a_k P + λ) θ_k =
/// c_k. The Gram matrix P of the prepared side is made tridiagonal once for each σ and fold, which
/// serves every label and λ; its eigenvalues are not needed. The sums of the largest label are the
/// total minus those of the others.
///
/// Single-threaded. `prepare` and `evaluate` do not allocate once they have had as many samples and
/// labels (up to 48 centres).
class LabelDependence {
 public:
  /// `options.form` must be kLinear; its seed draws the same centres and folds for every set.
  explicit LabelDependence(const FitOptions& options);

  /// Allocates memory for the given maximum numbers of samples, features and labels.
  void reserve(int samples, int features, int labels);

  /// Prepares n × d samples, finite and not all equal. Invalid samples or options become the reason
  /// of every estimate.
  void prepare(const Samples& samples);

  /// Static text: why nothing can be evaluated; "" if it can.
  const char* reason() const { return reason_; }

  /// Evaluates one label 0 … label_count − 1 per sample. With `hyper_parameters` (σ in the grid)
  /// there is no cross-validation.
  FitEstimate evaluate(std::span<const int32_t> labels, int label_count,
                       const std::optional<HyperParameters>& hyper_parameters = {});

 private:
  /// Gram matrix as rotationᵀ · T · rotation with T tridiagonal.
  struct Basis {
    Eigen::MatrixXd rotation;
    Eigen::VectorXd diagonal, subdiagonal;
  };
  /// Samples at one σ; the parts are the folds.
  struct Width {
    double sigma = 0;
    std::vector<double> features;        ///< Φ, centres × n, in order of fold
    std::vector<Eigen::VectorXd> sums;   ///< Σ Φ per fold
    std::vector<Eigen::MatrixXd> grams;  ///< ΦΦᵀ per fold
    Eigen::VectorXd sum;
    Eigen::MatrixXd gram;
    Basis basis;                                  ///< of the whole set
    std::vector<Basis> bases;                     ///< of all but one fold
    std::vector<Eigen::MatrixXd> held_out_grams;  ///< mean ΦΦᵀ of that fold, in its basis
  };

  void prepare_width(Width& width, Eigen::Index dimensions);
  void compute_basis(Basis& basis);
  void group_labels(std::span<const int32_t> labels, size_t parts);
  void sum_labels(const Width& width, size_t part, std::span<const double> sum, double* cross);
  void rotate(const double* cross, const Basis& basis, double scale, std::vector<double>& out);
  void eliminate(const Basis& basis, double lambda, const std::vector<double>& right);
  double compute_value(const Width& width, double lambda);
  void add_fold_errors(const Width& width, size_t fold);
  std::optional<HyperParameters> cross_validate();

  FitOptions options_;
  const char* reason_ = "no samples";
  Folds folds_;
  std::vector<int> centres_;
  std::vector<Width> widths_;
  size_t b_ = 0;  ///< number of centres
  size_t k_ = 0;  ///< number of labels of the evaluation

  // Scratch.
  std::vector<double> ordered_;
  std::vector<int> row_indices_;
  Eigen::MatrixXd centre_samples_, train_, half_;
  Eigen::Tridiagonalization<Eigen::MatrixXd> reduction_{2};
  Eigen::VectorXd workspace_;
  std::vector<int> group_begin_, group_fill_, grouped_;  ///< samples by fold, then by label
  std::vector<double> cross_, total_;  ///< Σ Φ per label: of a fold, and of the whole set
  std::vector<double> label_shares_;   ///< a_k
  std::vector<double> rotated_columns_, rotated_, held_out_cross_, ratio_, pivot_, theta_, stack_,
      product_, errors_;
};

}  // namespace infuse::dependence
