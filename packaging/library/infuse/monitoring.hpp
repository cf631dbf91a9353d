#pragma once

/// @file
/// Detection of drift of a calibration while driving.

#include "fusion/features/sweep_view.hpp"
#include "fusion/monitoring/axis.hpp"
#include "fusion/monitoring/calibration_monitor.hpp"
#include "fusion/monitoring/delay_ambiguity.hpp"
#include "fusion/monitoring/drift_verdict.hpp"
#include "fusion/monitoring/reestimate.hpp"
#include "infuse/layout.hpp"
