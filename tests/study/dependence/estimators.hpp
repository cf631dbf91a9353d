#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "fusion/dependence/estimate.hpp"

namespace infuse::study {

using dependence::Estimate;

/// Pairs of scalar samples, one per column.
using SamplePairs = Eigen::Matrix2Xd;

/// Correlation of the bivariate Gaussian on which the estimators are compared.
inline constexpr double kRho = 0.5;

/// An estimator of a quantity of pairs of scalars.
struct Estimator {
  std::string key;       ///< name on the command line
  std::string name;      ///< name in the table
  std::string quantity;  ///< estimated quantity
  double truth;          ///< value for the standard bivariate Gaussian of correlation `kRho`
  std::function<Estimate(const SamplePairs&)> estimate;
  int max_trials = 200;  ///< maximum number of repetitions in the comparison; fewer for slow ones
};

/// Returns all estimators, of the product and of the study. They expect samples of about zero mean
/// and unit variance.
std::vector<Estimator> make_estimators();

}  // namespace infuse::study
