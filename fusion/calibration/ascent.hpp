#pragma once

#include <functional>

#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::calibration {

template <int N>
using Parameters = Eigen::Matrix<double, N, 1>;

/// Function of N scaled parameters that is maximised. Fills in `gradient` where that is not null.
template <int N>
using ObjectiveFunction = std::function<double(const Parameters<N>& d, Parameters<N>* gradient)>;
using PoseFunction = ObjectiveFunction<6>;

/// Stopping rule of an ascent.
struct AscentOptions {
  int max_iterations = 60;  ///< bounds time: fewer suffice, or it has not converged
  double tolerance = 1e-4;  ///< a shorter step ends the search
  double max_step = 1;      ///< maximum step, by definition of the parameters' scales
};

/// End of an ascent over N parameters.
template <int N>
struct AscentResult {
  Parameters<N> d = Parameters<N>::Zero();
  double value = 0;
  bool converged = false;  ///< false: `max_iterations` was reached before
};
using PoseAscentResult = AscentResult<6>;

/// Quasi-Newton ascent from 0 after Broyden, Fletcher, Goldfarb and Shanno (I 4.2.3; Nocedal and
/// Wright, 6.1), with a bounded step and backtracking. Line searches of libraries lengthen the step
/// until the function falls, and so pass over the nearest of many maxima.
PoseAscentResult ascend_bfgs(const PoseFunction& function, const AscentOptions& options);
/// The same for ten parameters: a pose and four intrinsics of a camera.
AscentResult<10> ascend_bfgs_10d(const ObjectiveFunction<10>& function,
                                 const AscentOptions& options);

/// Nelder and Mead's simplex from 0 with the usual coefficients (1, 2, ½, ½); needs no gradient.
PoseAscentResult ascend_simplex(const PoseFunction& function, const AscentOptions& options);

}  // namespace infuse::calibration
