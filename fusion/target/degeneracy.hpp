#pragma once

#include <span>
#include <string>

#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/target/target_view.hpp"

namespace infuse::target {

/// Which motion the views leave free, P 3.2.3, in words; empty where none is. Normals that lie in a
/// plane to within 3 degrees count as if they did.
std::string describe_degeneracy(std::span<const TargetView* const> views);

/// The direction that a covariance knows worse than `rotation` (rad) or `translation` (m), one
/// standard deviation, in words; empty where there is none.
std::string describe_uncertain_axis(const geometry::Matrix6& covariance, double rotation,
                                    double translation);

}  // namespace infuse::target
