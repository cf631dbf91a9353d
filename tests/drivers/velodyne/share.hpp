#pragma once

#include <memory>
#include <optional>

#include "drivers/velodyne/velodyne_maker.hpp"

namespace infuse::velodyne {

/// A calibration as the decoder's options carry it.
inline std::shared_ptr<const lidar::UnitCalibration> share(
    Model model, const std::optional<Calibration>& calibration) {
  return calibration ? std::make_shared<UnitCalibration>(model, *calibration) : nullptr;
}

}  // namespace infuse::velodyne
