#include "daemon/tools/calibrate/time_sigma.hpp"

#include <spdlog/fmt/fmt.h>

namespace infuse::daemon {
namespace {

constexpr Duration kOfGlobalShutter{1'000'000};
constexpr Duration kOfArrival{9'600'000};  // uniform over 1/30 s, a webcam's interval: 33.3 ms/√12

}  // namespace

TimeSigma default_time_sigma(std::span<const CameraMount> cameras) {
  for (const CameraMount& camera : cameras) {
    if (camera.readout == Duration::zero() || camera.stamp_delay_sigma != Duration::zero()) {
      continue;
    }
    return {kOfArrival,
            fmt::format("the exposures of '{}', which has a rolling shutter, are taken as known to "
                        "{:.1f} ms: --refine-delay estimates its delay, stamp_delay_sigma_ms or "
                        "--time-sigma state what is known",
                        camera.name, 1e3 * to_seconds(kOfArrival))};
  }
  return {kOfGlobalShutter, ""};
}

}  // namespace infuse::daemon
