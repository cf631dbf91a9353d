#pragma once

#include <optional>
#include <string>

#include "drivers/measurement/rig.hpp"

namespace infuse::recording {

// What no vehicle has, although its numbers are valid: units that were confused, places that were
// left empty. Each returns what is wrong, or nothing.

/// A focal length of no lens, pixels that are far from square, a principal point outside the image,
/// a distortion that folds the image.
std::optional<std::string> find_impossible(const CameraIntrinsics& intrinsics);

/// Also an identity, which lets the camera look at the sky, and a sensor beyond the vehicle.
std::optional<std::string> find_impossible(const CameraMount& mount);

/// A sensor beyond the vehicle.
std::optional<std::string> find_impossible(const LidarMount& mount);

}  // namespace infuse::recording
