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

/// SMI between samples and labels by LSMI I(2.7–2.8), for one set of samples after another, each
/// asked with very many labellings: the particles of a street map. `PreparedDependence` gives the
/// same values; this one keeps its memory from set to set and costs half.
///
/// The delta kernel of labels makes the model fall apart into one system a label,
/// (a_k P + λ) θ_k = c_k. The prepared side's Gram matrix P is made tridiagonal once for each σ and
/// fold, which serves every label and λ; its eigenvalues are not needed. Of the sums of a
/// labelling, those of the largest label are what the others leave of the whole.
///
/// One thread at a time. `prepare` and `ask` allocate nothing once they had as many samples and
/// labels (up to 48 centres).
class LabelDependence {
 public:
  /// `options.form` must be kLinear; its seed draws the centres and folds of every set alike.
  explicit LabelDependence(const FitOptions& options);

  /// Takes the memory for as many samples, features and labels as there may be.
  void reserve(int samples, int features, int labels);

  /// Takes n × d samples, finite, not all alike. What is wrong with them or with the options is the
  /// reason of every answer.
  void prepare(const Samples& samples);

  /// Static text: why no question can be answered; "" where all is well.
  const char* reason() const { return reason_; }

  /// Asks with one label 0 … label_count − 1 a sample. `kept` (its σ one of the grid's) leaves out
  /// the cross-validation.
  FitEstimate evaluate(std::span<const int32_t> labels, int label_count,
                       const std::optional<HyperParameters>& hyper_parameters = {});

 private:
  /// A Gram matrix by a tridiagonal one: rotationᵀ · T · rotation.
  struct Basis {
    Eigen::MatrixXd rotation;
    Eigen::VectorXd diagonal, subdiagonal;
  };
  /// The samples at one σ; parts are the folds.
  struct Width {
    double sigma = 0;
    std::vector<double> features;        ///< Φ, centres × n, in order of fold
    std::vector<Eigen::VectorXd> sums;   ///< Σ Φ, by part
    std::vector<Eigen::MatrixXd> grams;  ///< ΦΦᵀ, by part
    Eigen::VectorXd sum;
    Eigen::MatrixXd gram;
    Basis basis;                                  ///< of the whole
    std::vector<Basis> bases;                     ///< of all but one part
    std::vector<Eigen::MatrixXd> held_out_grams;  ///< mean ΦΦᵀ of that part, in its basis
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
  size_t b_ = 0;  ///< centres
  size_t k_ = 0;  ///< labels of the question

  // Scratch.
  std::vector<double> ordered_;
  std::vector<int> row_indices_;
  Eigen::MatrixXd centre_samples_, train_, half_;
  Eigen::Tridiagonalization<Eigen::MatrixXd> reduction_{2};
  Eigen::VectorXd workspace_;
  std::vector<int> group_begin_, group_fill_, grouped_;  ///< samples by part, then label
  std::vector<double> cross_, total_;  ///< Σ Φ by label: a part's, and the whole's
  std::vector<double> label_shares_;   ///< a_k
  std::vector<double> rotated_columns_, rotated_, held_out_cross_, ratio_, pivot_, theta_, stack_,
      product_, errors_;
};

}  // namespace infuse::dependence
