#pragma once

/// @file
/// Features of returns and of images that the methods compare.

#include "fusion/features/discontinuity.hpp"
#include "fusion/features/fpfh.hpp"
#include "fusion/features/image_edges.hpp"
#include "fusion/features/local_contrast.hpp"
#include "fusion/features/relative_reflectivity.hpp"
#include "infuse/layout.hpp"
