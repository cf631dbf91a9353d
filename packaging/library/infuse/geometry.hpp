#pragma once

/// @file
/// Rigid motions, camera models, projection, trajectories.

#include "fusion/geometry/camera_model.hpp"
#include "fusion/geometry/extrinsic_error.hpp"
#include "fusion/geometry/project_points.hpp"
#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/geometry/trajectory.hpp"
#include "infuse/layout.hpp"
