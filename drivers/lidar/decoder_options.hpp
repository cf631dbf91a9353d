#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "drivers/lidar/unit_calibration.hpp"
#include "drivers/measurement/instruction_set.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::lidar {

struct LidarModel;

/// Options of a `LidarDecoder`.
struct DecoderOptions {
  const LidarModel* model = nullptr;
  /// Of this unit, as the model's maker has loaded it; null: the model's own.
  std::shared_ptr<const UnitCalibration> calibration{};
  double cut_azimuth = 0;  ///< °, clockwise from the front: azimuth at which a sweep ends and the
                           ///< next begins, −360 … 360
  bool interpolate_azimuth = true;  ///< false: every return has its sequence's azimuth, as in
                                    ///< simple viewers; wrong by up to 0.2°
  bool single_origin = false;  ///< all beams begin at the optical centre, as in simple viewers, if
                               ///< units are not calibrated individually
  uint32_t sender = 0;         ///< IPv4 address of the sensor, host byte order; 0: see `SenderLock`
  /// Maximum duration of a sweep, ns (for a sensor that does not turn).
  Duration max_span{400'000'000};

  InstructionSet instruction_set = best_instruction_set();  ///< all give the same bytes

  /// Returns what is wrong with the numbers, or nothing.
  std::optional<std::string> invalid() const;
};

}  // namespace infuse::lidar
