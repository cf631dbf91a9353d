#pragma once

#include <optional>
#include <string>

#include "drivers/camera/raw_image.hpp"

namespace infuse::camera {

/// Device and stream settings of a local camera.
struct V4l2Options {
  /// Path of the device. Paths in /dev/v4l/by-id and /dev/v4l/by-path stay the same when the camera
  /// is plugged in again.
  std::string device = "/dev/video0";
  int width = 0;                     ///< pixels; 0: the camera's current setting
  int height = 0;                    ///< pixels; 0: the camera's current setting
  double rate_hz = 0;                ///< images per second; 0: the camera's current setting
  std::optional<RawFormat> format;   ///< nothing: the camera's format that is cheapest to read
  bool grey = true;                  ///< omit colour if the format allows it
  std::optional<Duration> exposure;  ///< fixed; nothing: the camera's current setting
  std::optional<int> gain;           ///< fixed, in the driver's units; nothing: the current setting
  Duration stamp_delay{0};           ///< stamp minus middle of the exposure; subtracted

  /// Returns what is wrong with the numbers, or nothing.
  std::optional<std::string> invalid() const;

  bool operator==(const V4l2Options&) const = default;
};

}  // namespace infuse::camera
