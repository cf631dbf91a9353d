#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// Thresholds of the health checks: the `[health]` table of the configuration.
struct HealthOptions {
  Duration stale_after{3'000'000'000};   ///< silence after which a sensor is STALE, ns
  Duration raise_after{2'000'000'000};   ///< delay before another condition is raised, ns
  Duration clear_after{3'000'000'000};   ///< delay before a finding is cleared, ns
  Duration clock_grace{10'000'000'000};  ///< time for a clock to settle after the first packet, ns
  double warn_loss = 0.001;              ///< fraction of packets lost over 10 s that gives WARN
  double error_loss = 0.05;              ///< fraction of packets lost over 10 s that gives ERROR
  std::vector<std::string> expected_sensors;  ///< names of devices that must be configured

  /// Returns what is wrong with the options, or nothing.
  std::optional<std::string> invalid() const;
};

}  // namespace infuse::daemon
