#pragma once

/// @file
/// Lidars of all makers: models, decoders of their datagrams, and what a capture holds.

#include "drivers/lidar/lidar_decoder.hpp"
#include "drivers/lidar/lidar_maker.hpp"
#include "drivers/makers/capture_survey.hpp"
#include "drivers/makers/makers.hpp"
#include "infuse/layout.hpp"
