#pragma once

#include <cstdint>

namespace infuse::lidar {

/// Origin of a sensor's calibration.
enum class CalibrationSource : uint8_t {
  kBuiltIn,  ///< identical for all units, or an example, until the unit's own is known
  kFile,     ///< from a file
  kStream,   ///< from the sensor itself
};

/// Calibration of one unit, in its maker's own terms: what `LidarMaker::load_calibration` has read
/// from a file, or a decoder from the sensor's packets.
class UnitCalibration {
 public:
  virtual ~UnitCalibration() = default;
};

}  // namespace infuse::lidar
