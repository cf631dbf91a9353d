#pragma once

/// @file
/// Pose graphs: loop closures and their optimisation.

#include "fusion/mapping/closure_search.hpp"
#include "fusion/mapping/optimize.hpp"
#include "fusion/mapping/pose_graph.hpp"
#include "infuse/layout.hpp"
