#pragma once

/// @file
/// Localisation on a street map.

#include "fusion/streetmap/planar_pose.hpp"
#include "fusion/streetmap/rasterise.hpp"
#include "fusion/streetmap/segment.hpp"
#include "fusion/streetmap/segment_map.hpp"
#include "fusion/streetmap/street_plan.hpp"
#include "fusion/streetmap/tracker.hpp"
#include "infuse/layout.hpp"
