#pragma once

/// @file
/// Detection of drift of a calibration while driving.

#include "fusion/monitoring/calibration_monitor.hpp"
#include "fusion/monitoring/reestimate.hpp"
#include "infuse/layout.hpp"
