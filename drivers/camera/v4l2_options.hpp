#pragma once

#include <optional>
#include <string>

#include "drivers/camera/raw_image.hpp"

namespace infuse::camera {

/// Which camera of this host, and how it is to stream.
struct V4l2Options {
  /// A path that stays the same when the camera is plugged in again is in /dev/v4l/by-id or
  /// /dev/v4l/by-path.
  std::string device = "/dev/video0";
  int width = 0;                     ///< pixels; 0: as the camera is set
  int height = 0;                    ///< pixels; 0: as the camera is set
  double rate_hz = 0;                ///< pictures a second; 0: as the camera is set
  std::optional<RawFormat> format;   ///< nothing: the cheapest to read that the camera has
  bool grey = true;                  ///< leave colour out where the format allows it
  std::optional<Duration> exposure;  ///< fixed; nothing: as the camera is set
  std::optional<int> gain;           ///< fixed, in the driver's units; nothing: as it is set
  Duration stamp_delay{0};           ///< stamp minus middle of the exposure; subtracted

  /// What is wrong with the numbers, or nothing.
  std::optional<std::string> invalid() const;

  bool operator==(const V4l2Options&) const = default;
};

}  // namespace infuse::camera
