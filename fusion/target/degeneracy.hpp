#pragma once

#include <span>
#include <string>

#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/target/target_view.hpp"

namespace infuse::target {

/// Describes the motion that the views leave undetermined, P 3.2.3; empty if there is none. Normals
/// within 3 degrees of a plane count as coplanar.
std::string describe_degeneracy(std::span<const TargetView* const> views);

/// Describes the direction whose standard deviation exceeds `rotation` (rad) or `translation` (m);
/// empty if there is none.
std::string describe_uncertain_axis(const geometry::Matrix6& covariance, double rotation,
                                    double translation);

}  // namespace infuse::target
