#pragma once

#include <Eigen/Geometry>
#include <span>

#include "fusion/registration/registration_result.hpp"

namespace infuse::registration {

/// Finds the pose of a source's points in the frame of a target near a guess: both are prepared
/// (`prepare_cloud`) and registered by generalized ICP (`gicp`), with default settings. Points: m,
/// finite. Without points the result is not usable.
RegistrationResult align_points(
    std::span<const Eigen::Vector3f> target, std::span<const Eigen::Vector3f> source,
    const Eigen::Isometry3d& T_target_source_guess = Eigen::Isometry3d::Identity());

}  // namespace infuse::registration
