#pragma once

#include <functional>

#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::calibration {

template <int N>
using Parameters = Eigen::Matrix<double, N, 1>;

/// A function of N scaled parameters to be maximised. With a `gradient` it also fills that.
template <int N>
using ObjectiveFunction = std::function<double(const Parameters<N>& d, Parameters<N>* gradient)>;
using PoseFunction = ObjectiveFunction<6>;

/// When an ascent ends.
struct AscentOptions {
  int max_iterations = 60;
  double tolerance = 1e-4;  ///< a step shorter than this ends the search
  double max_step = 1;      ///< no step is longer: a longer one may land in another basin
};

/// Where an ascent of N parameters ended.
template <int N>
struct AscentResult {
  Parameters<N> d = Parameters<N>::Zero();
  double value = 0;
  bool converged = false;  ///< false: still moving when its iterations were used up
};
using PoseAscentResult = AscentResult<6>;

/// Quasi-Newton ascent from 0 after Broyden, Fletcher, Goldfarb and Shanno (I 4.2.3; Nocedal and
/// Wright, 6.1), with a bounded step and backtracking. Libraries' line searches lengthen the step
/// until the function falls, which a dependence with many maxima does only beyond the next hill.
PoseAscentResult ascend_bfgs(const PoseFunction& function, const AscentOptions& options);
/// The same with ten parameters: a pose, and four of a camera.
AscentResult<10> ascend_bfgs_10d(const ObjectiveFunction<10>& function,
                                 const AscentOptions& options);

/// Nelder and Mead's simplex from 0 with the usual coefficients (1, 2, ½, ½); asks for no gradient.
PoseAscentResult ascend_simplex(const PoseFunction& function, const AscentOptions& options);

}  // namespace infuse::calibration
