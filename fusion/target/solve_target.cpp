#include "fusion/target/solve_target.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "drivers/measurement/angles.hpp"
#include "drivers/measurement/median.hpp"
#include "fusion/target/degeneracy.hpp"
#include "fusion/target/view_consensus.hpp"

namespace infuse::target {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

constexpr int kRobustRounds = 10;  // bounds time: the weights have settled
constexpr int kRounds = 4;         // linearisations; bounds time: the start is within a degree
constexpr double kStudentFreedom =
    4;  // of the boards' shifts in the start, as in Lange et al. 1989
constexpr double kMadToSigma = 1.4826;  // 1 ÷ Φ⁻¹(¾): half of a Gaussian, 50 % of it, lies within
constexpr double kMinNoise = 1e-6;  // m, without noise; its square is far above double precision

/// The views with their equations at one pose.
class Solver {
 public:
  Solver(std::span<const TargetView> views, const SolveTargetOptions& options)
      : views_(views),
        options_(options),
        model_(views),
        prior_(model_.prior_information(options.errors)),
        biases_(Eigen::VectorXd::Zero(model_.size())),
        equations_(views.size()),
        used_(views.size(), true) {
    for (const TargetView& view : views) corners_.push_back(TargetModel::shift_covariance(view));
  }

  /// Robust estimate of the pose; marks the outliers.
  void start(const Eigen::Isometry3d& T_initial);

  /// Estimate from the views that are not outliers.
  void solve();

  /// Views that are not outliers.
  std::vector<const TargetView*> used_views() const;

  void write(TargetResult& result) const;

 private:
  void linearise();
  void apply(const TargetSolution& solution);
  void estimate_noise();
  double distance_of(size_t i, const ShiftCovariance& misfit) const;
  Misfit robust_misfit() const;

  template <class T>
  std::vector<T> of_used(const std::vector<T>& all) const {
    std::vector<T> some;
    for (size_t i = 0; i < all.size(); ++i) {
      if (used_[i]) some.push_back(all[i]);
    }
    return some;
  }

  std::span<const TargetView> views_;
  const SolveTargetOptions& options_;
  TargetModel model_;
  Eigen::MatrixXd prior_;
  Eigen::Isometry3d T_ = Eigen::Isometry3d::Identity();
  Eigen::VectorXd biases_;  // shared parameters; those of the pose are 0
  std::vector<ViewEquations> equations_;
  std::vector<ShiftCovariance> corners_;  // covariances of the boards' shifts by their corners
  std::vector<BoardShift> shifts_;
  std::vector<bool> used_;
  double noise_ = kMinNoise;
  Misfit misfit_;
  TargetSolution solution_;
};

void Solver::linearise() {
  shifts_.clear();
  for (size_t i = 0; i < views_.size(); ++i) {
    equations_[i] = model_.linearise(i, T_);
    shifts_.push_back(fit_shift(equations_[i], biases_));
  }
  estimate_noise();
}

void Solver::estimate_noise() {
  double squares = 0;
  double freedom = 0;
  for (size_t i = 0; i < views_.size(); ++i) {
    if (!used_[i]) continue;
    squares += remaining_squares(equations_[i], biases_, shifts_[i]);
    freedom += equations_[i].returns - 3;
  }
  freedom -= static_cast<double>(model_.size() - TargetModel::kFirstBeam);
  noise_ = std::max(kMinNoise, std::sqrt(std::max(0.0, squares) / std::max(1.0, freedom)));
}

void Solver::apply(const TargetSolution& solution) {
  biases_ = solution.shared;
  T_ = geometry::exp(Vector6(biases_.head<6>())) * T_;
  biases_.head<6>().setZero();
}

double Solver::distance_of(size_t i, const ShiftCovariance& misfit) const {
  const ShiftCovariance covariance =
      corners_[i] + misfit + noise_ * noise_ * equations_[i].own.inverse();
  return std::sqrt(std::max(0.0, shifts_[i].dot(covariance.inverse() * shifts_[i])));
}

Misfit Solver::robust_misfit() const {
  std::vector<double> offsets, tilts;
  for (const BoardShift& shift : shifts_) {
    offsets.push_back(std::abs(shift(0)));
    tilts.insert(tilts.end(), {std::abs(shift(1)), std::abs(shift(2))});
  }
  return {kMadToSigma * median(offsets), kMadToSigma * median(tilts)};
}

void Solver::start(const Eigen::Isometry3d& T_initial) {
  T_ = T_initial;
  std::vector<ShiftCovariance> covariances(views_.size());
  for (int round = 0; round < kRobustRounds; ++round) {
    linearise();
    misfit_ = robust_misfit();
    for (size_t i = 0; i < views_.size(); ++i) {
      const double distance = distance_of(i, misfit_.covariance());
      const double weight = (kStudentFreedom + 3) / (kStudentFreedom + distance * distance);
      covariances[i] = (corners_[i] + misfit_.covariance()) / weight;
    }
    apply(solve_views(equations_, covariances, prior_, noise_));
  }
  linearise();
  misfit_ = robust_misfit();
  for (size_t i = 0; i < views_.size(); ++i) {
    used_[i] = distance_of(i, misfit_.covariance()) <= options_.max_mahalanobis;
  }
}

void Solver::solve() {
  const auto corners = of_used(corners_);
  for (int round = 0; round < kRounds; ++round) {
    linearise();
    const auto equations = of_used(equations_);
    misfit_ = estimate_misfit(equations, corners, prior_, noise_);
    auto covariances = corners;
    for (ShiftCovariance& covariance : covariances) covariance += misfit_.covariance();
    // What the model does not explain of single boards may as well be common to all of them.
    Eigen::MatrixXd prior = prior_;
    prior.diagonal().segment<3>(TargetModel::kShift) =
        misfit_.covariance().diagonal().cwiseInverse();
    solution_ = solve_views(equations, covariances, prior, noise_);
    apply(solution_);
  }
  linearise();
}

std::vector<const TargetView*> Solver::used_views() const {
  std::vector<const TargetView*> some;
  for (size_t i = 0; i < views_.size(); ++i) {
    if (used_[i]) some.push_back(&views_[i]);
  }
  return some;
}

void Solver::write(TargetResult& result) const {
  result.T_refcam_lidar = T_;
  result.range_noise = noise_;
  result.misfit = misfit_;
  for (size_t i = 0; i < views_.size(); ++i) {
    const double squares = remaining_squares(equations_[i], biases_, shifts_[i]);
    result.views[i] = {std::sqrt(std::max(0.0, squares) / std::max(1.0, equations_[i].returns)),
                       shifts_[i](0), std::atan(shifts_[i].tail<2>().norm()),
                       distance_of(i, misfit_.covariance()), used_[i]};
    result.used += used_[i] ? 1 : 0;
  }
  if (solution_.shared.size() == 0) return;
  const auto beams = biases_.tail(model_.size() - TargetModel::kFirstBeam);
  result.beam_bias = std::sqrt(beams.squaredNorm() / static_cast<double>(beams.size()));
  result.contrast_bias = biases_(TargetModel::kContrast);
  result.leave_one_out = leave_one_out_ratio(solution_);
  // A variance estimated with n degrees of freedom widens by n ÷ (n − 2): Student's t.
  const double freedom = std::max(1.0, 3.0 * result.used - 6);
  const double widening = freedom > 2 ? freedom / (freedom - 2) : 3;
  result.covariance = widening * std::max(1.0, result.leave_one_out) * solution_.pose_covariance();
}

/// What neither corners nor returns explain may be common to all boards, and then it is the
/// result's.
std::string describe_misfit(const Misfit& misfit) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(),
                "the boards are off by %.1f mm and %.2f degrees more than corners and returns "
                "explain; check intrinsics, board and that nothing moves",
                1e3 * misfit.offset, misfit.tilt / kDegree);
  return text.data();
}

}  // namespace

std::optional<std::string> SolveTargetOptions::invalid() const {
  if (auto wrong = errors.invalid()) return wrong;
  if (!(max_mahalanobis > 0)) return "max_mahalanobis must be positive";
  if (!(max_rejected >= 0 && max_rejected <= 0.5)) return "max_rejected must be between 0 and 0.5";
  if (!(max_rotation_sigma > 0) || !(max_translation_sigma > 0)) {
    return "max_rotation_sigma and max_translation_sigma must be positive";
  }
  return std::nullopt;
}

TargetResult solve_target(std::span<const TargetView> views, const Eigen::Isometry3d& T_initial,
                          const SolveTargetOptions& options) {
  TargetResult result{.T_refcam_lidar = T_initial,
                      .views = std::vector<ViewResidual>(views.size(), {.used = false})};
  std::vector<ReturnsPlane> planes;
  for (const TargetView& view : views) planes.push_back(fit_returns_plane(view.returns));
  Solver solver(views, options);
  result.reason = describe_degeneracy(solver.used_views());
  if (!result.reason.empty()) return result;
  solver.start(find_consensus_pose(views, planes, options.seed).value_or(T_initial));
  result.reason = describe_degeneracy(solver.used_views());
  if (result.reason.empty()) solver.solve();
  solver.write(result);
  if (!result.reason.empty()) return result;
  const auto total = static_cast<int>(views.size());
  if (total - result.used > options.max_rejected * total) {
    result.reason =
        "too many boards do not agree with the others: " + std::to_string(total - result.used) +
        " of " + std::to_string(total);
  } else if (result.misfit.tilt > options.max_rotation_sigma ||
             result.misfit.offset > options.max_translation_sigma) {
    result.reason = describe_misfit(result.misfit);
  } else {
    result.reason = describe_uncertain_axis(result.covariance, options.max_rotation_sigma,
                                            options.max_translation_sigma);
  }
  return result;
}

}  // namespace infuse::target
