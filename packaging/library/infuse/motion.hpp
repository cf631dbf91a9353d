#pragma once

/// @file
/// Odometry from the samples of a vehicle, and deskewing by it.

#include "fusion/motion/deskew.hpp"
#include "fusion/motion/odometry_filter.hpp"
#include "fusion/motion/trajectory_error.hpp"
#include "infuse/layout.hpp"
