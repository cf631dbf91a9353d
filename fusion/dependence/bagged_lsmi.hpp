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
  int bags = 200;       ///< M of I(2.9)
  int bag_size = 2000;  ///< samples of a bag, drawn without repetition
  FitOptions fit;       ///< of each bag; its seed draws the bags and all their centres

  /// What is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

/// Bagged LSMI I(2.9): the mean of LSMI over bags drawn from the samples, with its gradient.
/// Prepared with the side that stays (the lidar's features), asked with the side that moves (the
/// image's features under a candidate calibration). The bags are fixed by the seed, so the value is
/// a smooth function of the moving side.
///
/// σ and λ come from cross-validation on the first bag at the first question, as in I 4.3.2, or
/// from `keep`; then they are held. Fixed once: each bag's rows, centres and the eigenvectors of
/// its fixed side (b² doubles a bag). Kernel matrices are formed anew for each question: to keep
/// them would take n·b doubles a bag.
///
/// `ask` and `keep` change the object: one thread at a time.
class BaggedLsmi {
 public:
  /// `fixed`: N × d, N >= bag_size. What is wrong is the reason of every answer.
  BaggedLsmi(const Samples& fixed, const BagOptions& options);

  /// Static text: why no question can be answered; "" where all is well.
  const char* reason() const { return reason_; }

  /// Holds these hyper-parameters from now on (σ need not be in the grid). Values outside what
  /// FitOptions allows are the reason of the next answers.
  void set_hyper_parameters(const HyperParameters& hyper_parameters);

  /// What is held; nothing before the first question or `keep`.
  const std::optional<HyperParameters>& hyper_parameters() const { return hyper_parameters_; }

  /// Mean LSMI of the bags with `moving`, N × d'. With `gradient` also ∂value/∂moving, N × d', zero
  /// where a sample is in no bag; empty where the answer is not usable.
  FitEstimate evaluate(const Samples& moving, Eigen::MatrixXd* gradient = nullptr);

 private:
  struct Bag {
    std::vector<int> rows;         ///< of the samples, ascending
    std::vector<int> centre_rows;  ///< places in `rows`
    SpectralBasis fixed_basis;     ///< of the fixed side at the kept σ
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

  // Scratch of a question.
  Eigen::MatrixXd samples_, centres_, fixed_features_, moving_features_, gram_, cross_, rotated_;
  Eigen::MatrixXd theta_, sensitivity_, bag_gradient_;
};

}  // namespace infuse::dependence
