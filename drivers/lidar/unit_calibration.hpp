#pragma once

#include <cstdint>

namespace infuse::lidar {

/// Origin of a sensor's calibration.
enum class CalibrationSource : uint8_t {
  kBuiltIn,  ///< identical for all units, or an example, until the unit's own is known
  kFile,     ///< from a file
  kStream,   ///< from the sensor itself
};

struct LidarModel;

/// Calibration of one unit of a model, in its maker's own terms: what
/// `LidarMaker::load_calibration` has read from a file, or a decoder from the sensor's packets.
struct UnitCalibration {
  explicit UnitCalibration(const LidarModel* of_model) : model(of_model) {}
  virtual ~UnitCalibration() = default;

  const LidarModel* const model;
};

}  // namespace infuse::lidar
