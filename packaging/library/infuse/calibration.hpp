#pragma once

/// @file
/// Extrinsic calibration of cameras to a lidar, and the comparison of two of them.

#include "fusion/calibration/calibrate.hpp"
#include "fusion/calibration/compare_extrinsics.hpp"
#include "fusion/calibration/named_measures.hpp"
#include "fusion/calibration/scene.hpp"
#include "infuse/layout.hpp"
