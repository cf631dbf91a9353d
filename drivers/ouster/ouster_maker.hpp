#pragma once

#include "drivers/lidar/lidar_maker.hpp"

namespace infuse::ouster {

/// Ouster, for the list of makers.
const lidar::LidarMaker& maker();

}  // namespace infuse::ouster
