#pragma once

/// @file
/// Poses between point clouds, with and without a guess, and the odometry of a lidar.

#include "fusion/registration/align_points.hpp"
#include "fusion/registration/gicp.hpp"
#include "fusion/registration/global_guess.hpp"
#include "fusion/registration/lidar_odometry.hpp"
#include "fusion/registration/lidar_odometry_options.hpp"
#include "fusion/registration/lidar_trajectory.hpp"
#include "fusion/registration/prepared_cloud.hpp"
#include "fusion/registration/registration_result.hpp"
#include "infuse/layout.hpp"
