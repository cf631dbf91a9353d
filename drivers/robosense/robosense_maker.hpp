#pragma once

#include <optional>

#include "drivers/lidar/lidar_model.hpp"
#include "drivers/lidar/unit_calibration.hpp"
#include "drivers/robosense/calibration.hpp"
#include "drivers/robosense/packet.hpp"

namespace infuse::robosense {

/// RoboSense, for the list of makers.
const lidar::LidarMaker& maker();

/// What the list of makers knows of a model.
const lidar::LidarModel& lidar_model(Model model);

/// The model that an entry of this maker's list is.
Model model_of(const lidar::LidarModel& model);

/// What the information packets of one RoboSense lidar state, as the decoder's options carry it.
struct UnitCalibration final : lidar::UnitCalibration {
  UnitCalibration(Model of_model, const Calibration& of_unit, std::optional<ReturnMode> of_packets)
      : lidar::UnitCalibration(&lidar_model(of_model)), calibration(of_unit), mode(of_packets) {}
  Calibration calibration;
  std::optional<ReturnMode> mode;
};

}  // namespace infuse::robosense
