#pragma once

#include "drivers/lidar/lidar_maker.hpp"
#include "drivers/ouster/metadata.hpp"

namespace infuse::ouster {

/// Ouster, for the list of makers.
const lidar::LidarMaker& maker();

/// The model that metadata states; null if it is none of the list.
const lidar::LidarModel* model_of(const Metadata& metadata);

}  // namespace infuse::ouster
