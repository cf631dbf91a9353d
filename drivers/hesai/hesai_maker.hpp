#pragma once

#include "drivers/hesai/calibration.hpp"
#include "drivers/lidar/lidar_model.hpp"
#include "drivers/lidar/unit_calibration.hpp"

namespace infuse::hesai {

/// Hesai, for the list of makers.
const lidar::LidarMaker& maker();

/// What the list of makers knows of a model.
const lidar::LidarModel& lidar_model(Model model);

/// The model that an entry of this maker's list is.
Model model_of(const lidar::LidarModel& model);

/// A calibration of one Hesai lidar as the decoder's options carry it.
struct UnitCalibration final : lidar::UnitCalibration {
  UnitCalibration(Model of_model, const Calibration& of_unit)
      : lidar::UnitCalibration(&lidar_model(of_model)), calibration(of_unit) {}
  Calibration calibration;
};

}  // namespace infuse::hesai
