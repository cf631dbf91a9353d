#pragma once

#include <optional>
#include <string>

#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// When a sensor is called unwell. The `[health]` table of the configuration.
struct HealthOptions {
  Duration stale_after{3'000'000'000};   ///< silence after which a sensor is STALE, ns
  Duration raise_after{2'000'000'000};   ///< how long another condition holds before it is told, ns
  Duration clear_after{3'000'000'000};   ///< how long it is absent before it is taken back, ns
  Duration clock_grace{10'000'000'000};  ///< after the first packet, until a clock must be followed
  double warn_loss = 0.001;              ///< fraction of packets lost over 10 s that is a WARN
  double error_loss = 0.05;              ///< and that is an ERROR

  /// What is wrong with the numbers, or nothing.
  std::optional<std::string> invalid() const;
};

}  // namespace infuse::daemon
