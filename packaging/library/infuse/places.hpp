#pragma once

/// @file
/// Recognition of places, and localisation on a map of keyframes.

#include "fusion/places/localiser.hpp"
#include "fusion/places/place_index.hpp"
#include "infuse/layout.hpp"
