#pragma once

/// @file
/// Images of files and of cameras, decoded.

#include "drivers/camera/image_decoder.hpp"
#include "infuse/layout.hpp"
