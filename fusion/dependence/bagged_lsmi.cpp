#include "fusion/dependence/bagged_lsmi.hpp"

#include <cmath>

#include "fusion/dependence/matrix_product.hpp"
#include "fusion/dependence/prepared_dependence.hpp"
#include "fusion/dependence/sample_choice.hpp"
#include "fusion/dependence/smi_gradient.hpp"

namespace infuse::dependence {

using Eigen::Index;
using Eigen::MatrixXd;

std::optional<std::string> BagOptions::invalid() const {
  if (bags < 1 || bags > 100000) return "bags must be 1 … 100000";
  if (bag_size < 2 || bag_size > 1000000) return "bag_size must be 2 … 1000000";
  return fit.invalid();
}

BaggedLsmi::BaggedLsmi(const Samples& fixed, const BagOptions& options)
    : options_(options), fixed_(fixed) {
  reason_ = options.invalid() ? "invalid options" : unusable(fixed);
  if (*reason_ == '\0' && fixed.rows() < options.bag_size) reason_ = "fewer samples than bag_size";
  if (*reason_ != '\0') return;
  Random random(options.fit.seed);
  bags_.resize(static_cast<size_t>(options.bags));
  for (Bag& bag : bags_) {
    bag.rows = choose_subset(static_cast<int>(fixed.rows()), options.bag_size, random);
    bag.centre_rows = choose_subset(options.bag_size, options.fit.centres, random);
  }
}

void BaggedLsmi::fixed_features(const Bag& bag, MatrixXd& features) {
  take_rows(fixed_, bag.rows, samples_);
  take_rows(samples_, bag.centre_rows, centres_);
  gaussian_kernel(samples_, centres_, kept_->sigma, features);
}

void BaggedLsmi::keep(const HyperParameters& hyper_parameters) {
  const bool prepared = kept_valid_ && kept_->sigma == hyper_parameters.sigma;
  kept_ = hyper_parameters;
  FitOptions check;
  check.sigmas = {hyper_parameters.sigma};
  check.lambdas = {hyper_parameters.lambda};
  kept_valid_ = !check.invalid();
  if (prepared || !kept_valid_ || *reason_ != '\0') return;
  for (Bag& bag : bags_) {
    fixed_features(bag, fixed_features_);
    multiply_by_transpose(fixed_features_, gram_);
    bag.fixed_basis = spectral_basis(gram_ / static_cast<double>(bag.rows.size()));
  }
}

const char* BaggedLsmi::choose(const Samples& moving) {
  if (kept_) return kept_valid_ ? "" : "the kept hyper-parameters are out of range";
  take_rows(fixed_, bags_[0].rows, samples_);
  PreparedDependence first(FitMeasure::kSmi, samples_, options_.fit);
  take_rows(moving, bags_[0].rows, samples_);
  const FitEstimate fit = first.ask(samples_);
  if (fit.usable()) keep(fit.chosen);
  return fit.reason;
}

double BaggedLsmi::ask_bag(const Bag& bag, const Samples& moving, MatrixXd* gradient) {
  const double n = static_cast<double>(bag.rows.size());
  fixed_features(bag, fixed_features_);
  take_rows(moving, bag.rows, samples_);
  take_rows(samples_, bag.centre_rows, centres_);
  gaussian_kernel(samples_, centres_, kept_->sigma, moving_features_);
  multiply_by_transpose(moving_features_, gram_);
  const TridiagonalBasis basis = tridiagonal_basis(gram_ / n);
  multiply(fixed_features_, moving_features_.transpose(), cross_);
  cross_ /= n;
  multiply(bag.fixed_basis.rotation, cross_, rotated_);
  if (basis.rotation.size() == 0) {
    cross_ = rotated_;
  } else {
    multiply(rotated_, basis.rotation.transpose(), cross_);
  }
  solve_sylvester(bag.fixed_basis.eigenvalues, basis, kept_->lambda, cross_, theta_);
  double value = 0.5 * theta_.cwiseProduct(cross_).sum() - 0.5;
  if (options_.fit.form == SmiForm::kPlugIn) value += 0.5 * kept_->lambda * theta_.squaredNorm();
  if (gradient == nullptr) return value;

  smi_sensitivity({bag.fixed_basis, basis, theta_, kept_->lambda, options_.fit.form},
                  fixed_features_, moving_features_, sensitivity_);
  gaussian_kernel_gradient(samples_, bag.centre_rows, kept_->sigma, moving_features_, sensitivity_,
                           bag_gradient_);
  for (Index f = 0; f < bag_gradient_.cols(); ++f) {
    for (Index i = 0; i < bag_gradient_.rows(); ++i) {
      (*gradient)(bag.rows[static_cast<size_t>(i)], f) += bag_gradient_(i, f);
    }
  }
  return value;
}

FitEstimate BaggedLsmi::ask(const Samples& moving, MatrixXd* gradient) {
  FitEstimate answer;
  if (gradient != nullptr) gradient->resize(0, 0);
  answer.reason = *reason_ != '\0' ? reason_ : unusable(moving);
  if (answer.usable() && moving.rows() != fixed_.rows()) {
    answer.reason = "the two sides differ in length";
  }
  if (answer.usable()) answer.reason = choose(moving);
  if (!answer.usable()) return answer;
  answer.chosen = *kept_;

  const double bags = static_cast<double>(bags_.size());
  if (gradient != nullptr) gradient->setZero(moving.rows(), moving.cols());
  double sum = 0;
  for (const Bag& bag : bags_) {
    if (bag.fixed_basis.rotation.size() == 0) {
      answer.reason = "the kernels of a bag's fixed side are singular";
      break;
    }
    sum += ask_bag(bag, moving, gradient);
  }
  if (answer.usable() && !std::isfinite(sum)) {
    answer.reason = "the kernels are singular at this lambda";
  }
  if (answer.usable()) {
    answer.value = sum / bags;
    if (gradient != nullptr) *gradient /= bags;
  } else if (gradient != nullptr) {
    gradient->resize(0, 0);
  }
  return answer;
}

}  // namespace infuse::dependence
