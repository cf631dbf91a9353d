#include "fusion/calibration/ascent.hpp"

#include <algorithm>
#include <array>

namespace infuse::calibration {
namespace {

using geometry::Vector6;

constexpr double kInitialStep = 0.3;  // length of the first step, before the curvature is known
constexpr double kBacktrackFactor =
    0.4;                            // applied to a step that does not raise the function enough
constexpr int kMaxBacktracks = 12;  // bounds time: steps are then below usual tolerances
constexpr double kArmijoFraction = 1e-4;  // share of the predicted rise (Nocedal and Wright 3.1)

template <int N>
using Square = Eigen::Matrix<double, N, N>;

/// Parameters, the function's value and its gradient there.
template <int N>
struct Iterate {
  Parameters<N> d = Parameters<N>::Zero();
  double value = 0;
  Parameters<N> slope = Parameters<N>::Zero();
};

template <int N>
Iterate<N> evaluate(const ObjectiveFunction<N>& function, const Parameters<N>& d) {
  Iterate<N> iterate{.d = d};
  iterate.value = function(d, &iterate.slope);
  return iterate;
}

/// Backtracks along `step` until the function has risen enough; false if it never does.
template <int N>
bool line_search(const ObjectiveFunction<N>& function, const Iterate<N>& from, Parameters<N> step,
                 Iterate<N>& to) {
  for (int i = 0; i < kMaxBacktracks; ++i) {
    to = evaluate<N>(function, from.d + step);
    if (to.value > from.value + kArmijoFraction * step.dot(from.slope)) return true;
    step *= kBacktrackFactor;
  }
  return false;
}

/// Inverse of minus the second derivative, estimated from the steps so far.
template <int N>
class InverseCurvature {
 public:
  explicit InverseCurvature(const Parameters<N>& slope) { restart(slope); }

  void restart(const Parameters<N>& slope) {
    inverse_ = Square<N>::Identity() * (kInitialStep / slope.norm());
    fresh_ = true;
  }
  bool fresh() const { return fresh_; }
  Parameters<N> times(const Parameters<N>& slope) const { return inverse_ * slope; }

  void update(const Iterate<N>& from, const Iterate<N>& to) {
    const Parameters<N> s = to.d - from.d;
    const Parameters<N> y = from.slope - to.slope;
    const double sy = s.dot(y);
    if (!(sy > 1e-9 * s.norm() * y.norm())) return;  // convex here: no information about a maximum
    if (fresh_) inverse_ = Square<N>::Identity() * (sy / y.squaredNorm());
    const Square<N> A = Square<N>::Identity() - s * y.transpose() / sy;
    inverse_ = A * inverse_ * A.transpose() + s * s.transpose() / sy;
    fresh_ = false;
  }

 private:
  Square<N> inverse_;
  bool fresh_ = true;
};

template <int N>
AscentResult<N> bfgs(const ObjectiveFunction<N>& function, const AscentOptions& options) {
  Iterate<N> at = evaluate<N>(function, Parameters<N>::Zero());
  if (at.slope.norm() == 0) return {.value = at.value, .converged = true};
  InverseCurvature<N> curvature(at.slope);
  for (int i = 0; i < options.max_iterations; ++i) {
    Parameters<N> step = curvature.times(at.slope);
    if (step.norm() > options.max_step) step *= options.max_step / step.norm();
    if (step.norm() < options.tolerance) return {at.d, at.value, true};
    Iterate<N> next;
    if (line_search(function, at, step, next)) {
      curvature.update(at, next);
      at = next;
    } else {
      // The gradient's own direction does not lead up: a maximum within rounding.
      if (curvature.fresh() || at.slope.norm() == 0) return {at.d, at.value, true};
      curvature.restart(at.slope);
    }
  }
  return {at.d, at.value, false};
}

}  // namespace

PoseAscentResult ascend_bfgs(const PoseFunction& function, const AscentOptions& options) {
  return bfgs<6>(function, options);
}

AscentResult<10> ascend_bfgs_10d(const ObjectiveFunction<10>& function,
                                 const AscentOptions& options) {
  return bfgs<10>(function, options);
}

PoseAscentResult ascend_simplex(const PoseFunction& function, const AscentOptions& options) {
  struct Vertex {
    Vector6 d;
    double value;
  };
  const auto evaluate = [&](const Vector6& d) { return Vertex{d, function(d, nullptr)}; };
  std::array<Vertex, 7> vertices{};
  for (size_t i = 0; i < 7; ++i) {
    Vector6 d = Vector6::Zero();
    if (i > 0) d(static_cast<Eigen::Index>(i) - 1) = options.max_step / 2;
    vertices[i] = evaluate(d);
  }
  const auto order = [&] {
    std::stable_sort(vertices.begin(), vertices.end(),
                     [](const Vertex& a, const Vertex& b) { return a.value > b.value; });
  };
  const auto shrink = [&] {
    for (size_t k = 1; k < 7; ++k) vertices[k] = evaluate(0.5 * (vertices[0].d + vertices[k].d));
  };
  for (int i = 0; i < options.max_iterations; ++i) {
    order();
    Vertex& worst = vertices[6];
    if ((worst.d - vertices[0].d).norm() < options.tolerance) {
      return {vertices[0].d, vertices[0].value, true};
    }
    Vector6 centre = Vector6::Zero();
    for (size_t k = 0; k < 6; ++k) centre += vertices[k].d / 6;
    const Vertex reflected = evaluate(2 * centre - worst.d);
    if (reflected.value > vertices[0].value) {
      const Vertex expanded = evaluate(3 * centre - 2 * worst.d);
      worst = expanded.value > reflected.value ? expanded : reflected;
    } else if (reflected.value > vertices[5].value) {
      worst = reflected;
    } else {
      const bool outside = reflected.value > worst.value;
      const Vertex contracted = evaluate(0.5 * (centre + (outside ? reflected.d : worst.d)));
      if (contracted.value > std::max(reflected.value, worst.value)) {
        worst = contracted;
      } else {
        shrink();
      }
    }
  }
  order();
  return {vertices[0].d, vertices[0].value, false};
}

}  // namespace infuse::calibration
