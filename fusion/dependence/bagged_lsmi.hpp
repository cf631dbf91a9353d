#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "fusion/dependence/gaussian_kernel.hpp"
#include "fusion/dependence/least_squares.hpp"
#include "fusion/dependence/sylvester.hpp"

namespace infuse::dependence {

/// Settings of BLSMI.
struct BagOptions {
  int bags = 200;       ///< number of bags, M of I(2.9)
  int bag_size = 2000;  ///< samples per bag, drawn without replacement: I 4.3.2, of 20 scans
  FitOptions fit;       ///< fit of each bag; its seed draws the bags and their centres

  /// Returns what is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

/// Bagged LSMI I(2.9): the mean of LSMI over bags drawn from the samples, with its gradient.
/// Prepared with the fixed side (lidar features) and evaluated with the moving side (image features
/// under a candidate calibration). The seed fixes the bags, so the value is a smooth function of
/// the moving side.
///
/// σ and λ are chosen by cross-validation on the first bag at the first evaluation, as in I 4.3.2,
/// or set by `set_hyper_parameters`; then they are fixed. Prepared once: the rows, centres and
/// eigenvectors of the fixed side of each bag (b² doubles per bag). Kernel matrices are recomputed
/// at each evaluation: storing them would take n·b doubles per bag.
///
/// Single-threaded: `evaluate` and `set_hyper_parameters` change the object.
class BaggedLsmi {
 public:
  /// `fixed`: N × d, N >= bag_size. Invalid input becomes the reason of every estimate.
  BaggedLsmi(const Samples& fixed, const BagOptions& options);

  /// Static text: why nothing can be evaluated; "" if it can.
  const char* reason() const { return reason_; }

  /// Fixes the hyper-parameters (σ need not be in the grid). Values outside the range of FitOptions
  /// become the reason of later estimates.
  void set_hyper_parameters(const HyperParameters& hyper_parameters);

  /// Fixed hyper-parameters; nothing before the first evaluation or `set_hyper_parameters`.
  const std::optional<HyperParameters>& hyper_parameters() const { return hyper_parameters_; }

  /// Returns the mean LSMI of the bags with `moving`, N × d'. If `gradient` is given, sets it to
  /// ∂value/∂moving, N × d', zero for samples in no bag; empty if the estimate is unusable.
  FitEstimate evaluate(const Samples& moving, Eigen::MatrixXd* gradient = nullptr);

 private:
  struct Bag {
    std::vector<int> rows;         ///< sample indices, ascending
    std::vector<int> centre_rows;  ///< indices into `rows`
    SpectralBasis fixed_basis;     ///< of the fixed side at the fixed σ
  };
  const char* choose_hyper_parameters(const Samples& moving);
  double evaluate_bag(const Bag& bag, const Samples& moving, Eigen::MatrixXd* gradient);
  void compute_fixed_features(const Bag& bag, Eigen::MatrixXd& features);

  BagOptions options_;
  const char* reason_ = "";
  Eigen::MatrixXd fixed_;
  std::vector<Bag> bags_;
  std::optional<HyperParameters> hyper_parameters_;
  bool hyper_parameters_valid_ = false;

  // Scratch of an evaluation.
  Eigen::MatrixXd samples_, centres_, fixed_features_, moving_features_, gram_, cross_, rotated_;
  Eigen::MatrixXd theta_, sensitivity_, bag_gradient_;
};

}  // namespace infuse::dependence
