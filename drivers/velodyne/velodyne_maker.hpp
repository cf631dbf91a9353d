#pragma once

#include <optional>
#include <string_view>

#include "drivers/lidar/lidar_maker.hpp"
#include "drivers/velodyne/calibration.hpp"
#include "drivers/velodyne/model.hpp"

namespace infuse::velodyne {

/// Velodyne, for the list of makers.
const lidar::LidarMaker& maker();

/// What the list of makers knows of a model.
const lidar::LidarModel& lidar_model(Model model);

/// The model that an entry of this maker's list is.
Model model_of(const lidar::LidarModel& model);

/// Finds a model of this maker by name, as `lidar::find_model` does.
std::optional<Model> find_model(std::string_view name);

/// A calibration of one Velodyne as the decoder's options carry it.
struct UnitCalibration final : lidar::UnitCalibration {
  UnitCalibration(Model of_model, const Calibration& of_unit)
      : lidar::UnitCalibration(&lidar_model(of_model)), calibration(of_unit) {}
  Calibration calibration;
};

}  // namespace infuse::velodyne
