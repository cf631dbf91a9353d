#include <cmath>
#include <limits>

#include "fusion/dependence/matrix_product.hpp"
#include "fusion/dependence/sample_choice.hpp"
#include "fusion/dependence/sylvester.hpp"
#include "tests/study/dependence/paired_density_ratio.hpp"

namespace infuse::study {
namespace {

using namespace dependence;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Sums over samples: Σ ggᵀ, Σ llᵀ, Σ g∘l.
struct PairedSums {
  double n = 0;
  MatrixXd gram_x, gram_y;
  VectorXd product;

  MatrixXd h_matrix() const { return gram_x.cwiseProduct(gram_y) / (n * n); }
  VectorXd h_vector() const { return product / n; }
  PairedSums without(const PairedSums& part) const {
    return {n - part.n, gram_x - part.gram_x, gram_y - part.gram_y, product - part.product};
  }
};

template <class Features>
PairedSums paired_sums(const Features& g, const Features& l) {
  PairedSums sums;
  sums.n = static_cast<double>(g.cols());
  multiply_by_transpose(g, sums.gram_x);
  multiply_by_transpose(l, sums.gram_y);
  sums.product = g.cwiseProduct(l).rowwise().sum();
  return sums;
}

// Solutions α for every λ from one rotation.
struct PairedModel {
  SpectralBasis basis;
  VectorXd rotated;

  explicit PairedModel(const PairedSums& sums)
      : basis(spectral_basis(sums.h_matrix())), rotated(basis.rotation * sums.h_vector()) {}
  VectorXd alpha(double lambda) const {
    return basis.rotation.transpose() *
           (rotated.array() / (basis.eigenvalues.array() + lambda)).matrix();
  }
};

}  // namespace

FitEstimate paired_lsmi(const Samples& x, const Samples& y, const FitOptions& options) {
  FitEstimate answer;
  answer.reason = options.invalid() ? "invalid options" : check_paired_samples(x, y);
  const int n = static_cast<int>(x.rows());
  const int fold_count = options.effective_folds();
  if (answer.usable() && n < fold_count) answer.reason = "fewer samples than folds";
  if (!answer.usable()) return answer;

  Random random(options.seed);
  const std::vector<int> centres = choose_subset(n, options.centres, random);
  const Folds folds = make_folds(n, fold_count, random);
  MatrixXd xo, yo, xc, yc, g, l;
  gather_rows(x, folds.order, xo);
  gather_rows(y, folds.order, yo);
  gather_rows(x, centres, xc);
  gather_rows(y, centres, yc);

  double best = std::numeric_limits<double>::max();
  answer.reason = "no hyper-parameters of the grid give a finite fit";
  for (const double sigma : options.sigmas) {
    gaussian_kernel(xo, xc, sigma, g);
    gaussian_kernel(yo, yc, sigma, l);
    const PairedSums total = paired_sums(g, l);
    VectorXd errors = VectorXd::Zero(static_cast<Eigen::Index>(options.lambdas.size()));
    for (int f = 0; f < folds.count() && folds.count() > 1; ++f) {
      const int begin = folds.begin[static_cast<size_t>(f)];
      const PairedSums held_out =
          paired_sums(g.middleCols(begin, folds.size(f)), l.middleCols(begin, folds.size(f)));
      const PairedModel model(total.without(held_out));
      for (Eigen::Index k = 0; k < errors.size(); ++k) {
        const VectorXd alpha = model.alpha(options.lambdas[static_cast<size_t>(k)]);
        errors[k] += 0.5 * alpha.dot(held_out.h_matrix() * alpha) - held_out.h_vector().dot(alpha);
      }
    }
    const PairedModel model(total);
    for (Eigen::Index k = 0; k < errors.size(); ++k) {
      if (!(errors[k] < best)) continue;
      const double lambda = options.lambdas[static_cast<size_t>(k)];
      const VectorXd alpha = model.alpha(lambda);
      const double linear = total.h_vector().dot(alpha);
      double value = 0.5 * linear - 0.5;
      if (options.form == SmiForm::kPlugIn) value += 0.5 * lambda * alpha.squaredNorm();
      if (!std::isfinite(value)) continue;
      best = errors[k];
      answer.value = value;
      answer.reason = "";
      answer.hyper_parameters = {sigma, lambda};
    }
  }
  return answer;
}

}  // namespace infuse::study
