#pragma once

#include <cstdint>
#include <string_view>

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

  /// The text that the maker's ROS driver publishes beside the packets, without which they cannot
  /// be read; empty: none is needed.
  virtual std::string_view text() const { return {}; }

  const LidarModel* const model;
};

}  // namespace infuse::lidar
