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
  if (bags < 1 || bags > 100000) return "bags must be between 1 and 100000";
  if (bag_size < 2 || bag_size > 1000000) return "bag_size must be between 2 and 1000000";
  return fit.invalid();
}

BaggedLsmi::BaggedLsmi(const Samples& fixed, const BagOptions& options)
    : options_(options), fixed_(fixed) {
  reason_ = options.invalid() ? "invalid options" : check_samples(fixed);
  if (*reason_ == '\0' && fixed.rows() < options.bag_size) reason_ = "fewer samples than bag_size";
  if (*reason_ != '\0') return;
  Random random(options.fit.seed);
  bags_.resize(static_cast<size_t>(options.bags));
  for (Bag& bag : bags_) {
    bag.rows = choose_subset(static_cast<int>(fixed.rows()), options.bag_size, random);
    bag.centre_rows = choose_subset(options.bag_size, options.fit.centres, random);
  }
}

void BaggedLsmi::compute_fixed_features(const Bag& bag, MatrixXd& features) {
  gather_rows(fixed_, bag.rows, samples_);
  gather_rows(samples_, bag.centre_rows, centres_);
  gaussian_kernel(samples_, centres_, hyper_parameters_->sigma, features);
}

void BaggedLsmi::set_hyper_parameters(const HyperParameters& hyper_parameters) {
  const bool prepared =
      hyper_parameters_valid_ && hyper_parameters_->sigma == hyper_parameters.sigma;
  hyper_parameters_ = hyper_parameters;
  FitOptions check;
  check.sigmas = {hyper_parameters.sigma};
  check.lambdas = {hyper_parameters.lambda};
  hyper_parameters_valid_ = !check.invalid();
  if (prepared || !hyper_parameters_valid_ || *reason_ != '\0') return;
  for (Bag& bag : bags_) {
    compute_fixed_features(bag, fixed_features_);
    multiply_by_transpose(fixed_features_, gram_);
    bag.fixed_basis = spectral_basis(gram_ / static_cast<double>(bag.rows.size()));
  }
}

const char* BaggedLsmi::choose_hyper_parameters(const Samples& moving) {
  if (hyper_parameters_)
    return hyper_parameters_valid_ ? "" : "the given hyper-parameters are out of range";
  gather_rows(fixed_, bags_[0].rows, samples_);
  PreparedDependence first(FitMeasure::kSmi, samples_, options_.fit);
  gather_rows(moving, bags_[0].rows, samples_);
  const FitEstimate fit = first.evaluate(samples_);
  if (fit.usable()) set_hyper_parameters(fit.hyper_parameters);
  return fit.reason;
}

double BaggedLsmi::evaluate_bag(const Bag& bag, const Samples& moving, MatrixXd* gradient) {
  const double n = static_cast<double>(bag.rows.size());
  compute_fixed_features(bag, fixed_features_);
  gather_rows(moving, bag.rows, samples_);
  gather_rows(samples_, bag.centre_rows, centres_);
  gaussian_kernel(samples_, centres_, hyper_parameters_->sigma, moving_features_);
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
  solve_sylvester(bag.fixed_basis.eigenvalues, basis, hyper_parameters_->lambda, cross_, theta_);
  double value = 0.5 * theta_.cwiseProduct(cross_).sum() - 0.5;
  if (options_.fit.form == SmiForm::kPlugIn)
    value += 0.5 * hyper_parameters_->lambda * theta_.squaredNorm();
  if (gradient == nullptr) return value;

  smi_sensitivity({bag.fixed_basis, basis, theta_, hyper_parameters_->lambda, options_.fit.form},
                  fixed_features_, moving_features_, sensitivity_);
  gaussian_kernel_gradient(samples_, bag.centre_rows, hyper_parameters_->sigma, moving_features_,
                           sensitivity_, bag_gradient_);
  for (Index f = 0; f < bag_gradient_.cols(); ++f) {
    for (Index i = 0; i < bag_gradient_.rows(); ++i) {
      (*gradient)(bag.rows[static_cast<size_t>(i)], f) += bag_gradient_(i, f);
    }
  }
  return value;
}

FitEstimate BaggedLsmi::evaluate(const Samples& moving, MatrixXd* gradient) {
  FitEstimate answer;
  if (gradient != nullptr) gradient->resize(0, 0);
  answer.reason = *reason_ != '\0' ? reason_ : check_samples(moving);
  if (answer.usable() && moving.rows() != fixed_.rows()) {
    answer.reason = "the two sides differ in length";
  }
  if (answer.usable()) answer.reason = choose_hyper_parameters(moving);
  if (!answer.usable()) return answer;
  answer.hyper_parameters = *hyper_parameters_;

  const double bags = static_cast<double>(bags_.size());
  if (gradient != nullptr) gradient->setZero(moving.rows(), moving.cols());
  double sum = 0;
  for (const Bag& bag : bags_) {
    if (bag.fixed_basis.rotation.size() == 0) {
      answer.reason = "the kernel matrix of a bag's fixed side is singular";
      break;
    }
    sum += evaluate_bag(bag, moving, gradient);
  }
  if (answer.usable() && !std::isfinite(sum)) {
    answer.reason = "the kernel matrices are singular at this lambda";
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
