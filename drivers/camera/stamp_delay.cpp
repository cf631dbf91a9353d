#include "drivers/camera/stamp_delay.hpp"

#include <cmath>

namespace infuse::camera {

std::optional<std::string> StampDelay::invalid() const {
  if (!std::isfinite(bandwidth_bytes_s) || bandwidth_bytes_s < 0) {
    return "bandwidth_bytes_s must be 0 or positive";
  }
  if (constant > std::chrono::seconds(10) || constant < -std::chrono::seconds(10)) {
    return "the constant delay must lie within 10 s";
  }
  return std::nullopt;
}

Stamp StampDelay::exposure_stamp(Stamp stamped, size_t bytes) const {
  const Duration transfer = bandwidth_bytes_s > 0
                                ? from_seconds(static_cast<double>(bytes) / bandwidth_bytes_s)
                                : Duration::zero();
  return stamped - constant - transfer;
}

}  // namespace infuse::camera
