#include <algorithm>
#include <cmath>
#include <limits>

#include "fusion/dependence/sample_choice.hpp"
#include "tests/study/dependence/paired_density_ratio.hpp"

namespace infuse::study {
namespace {

using namespace dependence;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kGainTolerance = 1e-4;  // nats
constexpr int kMaxSteps = 500;           // maximum number of steps of the final fit
constexpr int kMaxValidationSteps = 50;  // maximum number of steps of the fits that choose σ

// r(x_i, y_i) = Σ_l w_l·G_li·L_li / m_l; with m_l = mean G_l · mean L_l, Σ w = 1 normalises the
// ratio.
struct RatioModel {
  VectorXd weights;  // w_l / m_l

  template <class Features>
  VectorXd ratios(const Features& product) const {
    return product.transpose() * weights;
  }
};

// Expectation-maximisation of the mixture weights. With g_l = mean basis_l/r, the remaining gain is
// at most max g − 1.
RatioModel maximise_likelihood(const MatrixXd& product, const VectorXd& means, int steps) {
  const double n = static_cast<double>(product.cols());
  const VectorXd scale = (means.array() > 0).select(means.cwiseInverse(), 0.0);
  VectorXd w = (means.array() > 0).cast<double>();
  w /= std::max(1.0, w.sum());
  RatioModel model;
  VectorXd gain(w.size());
  for (int step = 0; step < steps; ++step) {
    model.weights = w.cwiseProduct(scale);
    gain.setZero();
    for (Index i = 0; i < product.cols(); ++i) {
      const double ratio = product.col(i).dot(model.weights);
      gain += product.col(i) / std::max(ratio, std::numeric_limits<double>::min());
    }
    gain = gain.cwiseProduct(scale) / n;
    if (!(gain.maxCoeff() > 1 + kGainTolerance)) break;
    w.array() *= gain.array();
  }
  return model;
}

double mean_log(const VectorXd& ratios) {
  return ratios.array().max(std::numeric_limits<double>::min()).log().mean();
}

// What one training set needs: the products of its columns, and the means of both sides.
double held_out_log_likelihood(const MatrixXd& g, const MatrixXd& l, Index begin, Index count) {
  const Index rest = g.cols() - count;
  MatrixXd product(g.rows(), rest);
  product.leftCols(begin) = g.leftCols(begin).cwiseProduct(l.leftCols(begin));
  const Index after = rest - begin;
  product.rightCols(after) = g.rightCols(after).cwiseProduct(l.rightCols(after));
  const VectorXd sum_g = g.leftCols(begin).rowwise().sum() + g.rightCols(after).rowwise().sum();
  const VectorXd sum_l = l.leftCols(begin).rowwise().sum() + l.rightCols(after).rowwise().sum();
  const double n = static_cast<double>(rest);
  const RatioModel model =
      maximise_likelihood(product, sum_g.cwiseProduct(sum_l) / (n * n), kMaxValidationSteps);
  return mean_log(
      model.ratios(g.middleCols(begin, count).cwiseProduct(l.middleCols(begin, count))));
}

// other_features(folds, centres, σ): kernel values of the other side, centres × samples, in order
// of fold.
template <class OtherFeatures>
FitEstimate mlmi_with(const Samples& x, const OtherFeatures& other_features,
                      const FitOptions& options) {
  FitEstimate answer;
  const int n = static_cast<int>(x.rows());
  const int fold_count = options.sigmas.size() > 1 ? options.folds : 1;
  if (n < fold_count) {
    answer.reason = "fewer samples than folds";
    return answer;
  }
  Random random(options.seed);
  const std::vector<int> centres = choose_subset(n, options.centres, random);
  const Folds folds = make_folds(n, fold_count, random);
  MatrixXd ordered, at_centres, g;
  gather_rows(x, folds.order, ordered);
  gather_rows(x, centres, at_centres);

  double best = -std::numeric_limits<double>::infinity();
  MatrixXd best_g, best_l;
  for (const double sigma : options.sigmas) {
    gaussian_kernel(ordered, at_centres, sigma, g);
    MatrixXd l = other_features(folds, centres, sigma);
    double score = 0;
    for (int f = 0; f < folds.count() && folds.count() > 1; ++f) {
      score += held_out_log_likelihood(g, l, folds.begin[static_cast<size_t>(f)], folds.size(f));
    }
    if (!(score > best)) continue;
    best = score;
    best_g.swap(g);
    best_l.swap(l);
    answer.hyper_parameters.sigma = sigma;
  }
  if (best_g.size() == 0) {
    answer.reason = "no width of the grid gives a finite likelihood";
    return answer;
  }
  const MatrixXd product = best_g.cwiseProduct(best_l);
  const VectorXd means = best_g.rowwise().mean().cwiseProduct(best_l.rowwise().mean());
  const double value = mean_log(maximise_likelihood(product, means, kMaxSteps).ratios(product));
  if (std::isfinite(value)) {
    answer.value = value;
  } else {
    answer.reason = "the likelihood is not finite";
  }
  return answer;
}

}  // namespace

FitEstimate mlmi(const Samples& x, const Samples& y, const FitOptions& options) {
  FitEstimate answer;
  answer.reason = options.invalid() ? "invalid options" : check_paired_samples(x, y);
  if (!answer.usable()) return answer;
  const auto features = [&](const Folds& folds, const std::vector<int>& centres, double sigma) {
    MatrixXd ordered, at_centres, l;
    gather_rows(y, folds.order, ordered);
    gather_rows(y, centres, at_centres);
    gaussian_kernel(ordered, at_centres, sigma, l);
    return l;
  };
  return mlmi_with(x, features, options);
}

FitEstimate mlmi(const Samples& x, std::span<const int32_t> labels, int label_count,
                 const FitOptions& options) {
  FitEstimate answer;
  answer.reason = options.invalid() ? "invalid options" : check_samples(x);
  if (answer.usable()) answer.reason = check_labels(labels, x.rows(), label_count);
  if (!answer.usable()) return answer;
  const auto features = [&](const Folds& folds, const std::vector<int>& centres, double) {
    MatrixXd l(centres.size(), folds.order.size());
    for (size_t i = 0; i < folds.order.size(); ++i) {
      const int32_t label = labels[static_cast<size_t>(folds.order[i])];
      for (size_t c = 0; c < centres.size(); ++c) {
        const bool same = labels[static_cast<size_t>(centres[c])] == label;
        l(static_cast<Index>(c), static_cast<Index>(i)) = same ? 1.0 : 0.0;
      }
    }
    return l;
  };
  return mlmi_with(x, features, options);
}

}  // namespace infuse::study
