#pragma once

#include <cstdint>

namespace infuse::lidar {

class LidarMaker;

/// A model of lidar that can be decoded. Its maker owns it, so that a pointer identifies it.
struct LidarModel {
  const LidarMaker* maker = nullptr;
  const char* name = "";                       ///< "HDL-32E", as in drive.toml and in text
  uint16_t beams = 0;                          ///< number of rings
  bool calibrated_per_unit = false;            ///< each unit has its own calibration
  bool has_dual_return = false;                ///< can send two returns
  double min_turns_hz = 5, max_turns_hz = 20;  ///< turns per second that it can be set to
};

}  // namespace infuse::lidar
