#pragma once

#include <optional>
#include <string>

#include "drivers/measurement/stamp.hpp"

namespace infuse::camera {

/// How late a camera's stamps are: stamp = middle of the exposure + constant + bytes ÷ bandwidth.
/// The second part is a bus that is stamped at its far end (P C.5: 800 Mb/s FireWire).
struct StampDelay {
  Duration constant{0};  ///< also takes away half of the exposure where the stamp is its end
  double bandwidth_bytes_s = 0;  ///< bytes a second of the bus; 0: no such part

  /// What is wrong with the numbers, or nothing.
  std::optional<std::string> invalid() const;

  /// Middle of the exposure of a picture that came stamped `stamped` and crossed the bus as
  /// `bytes`.
  Stamp exposure_stamp(Stamp stamped, size_t bytes) const;
};

}  // namespace infuse::camera
