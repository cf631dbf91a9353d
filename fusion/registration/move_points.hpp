#pragma once

#include "drivers/measurement/sweep.hpp"
#include "fusion/geometry/project_points.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::registration {

/// Moves points in single precision: (x, y, z) = T · points. The outputs are at least as long as
/// the points. Same bytes on every processor.
void move_points(const Eigen::Isometry3d& T, const geometry::PointsView& points,
                 FieldVector<float>& x, FieldVector<float>& y, FieldVector<float>& z);

}  // namespace infuse::registration
