#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "daemon/health/conditions.hpp"

namespace infuse::daemon {

/// How the interface or device is that a live sensor is listened to on. Plain data: it crosses
/// threads by copy. In a replay it stays as it is made.
struct SourceState {
  bool open = true;                 ///< it can be read
  bool used = true;                 ///< fusion uses what it delivers; false: it is only counted
  uint32_t open_count = 0;          ///< how often it was opened
  uint64_t buffer_requested = 0;    ///< bytes of receive buffer; 0: it has none
  uint64_t buffer_granted = 0;      ///< by the kernel
  const char* stamp_source = "";    ///< of a CAN bus, whose: "hardware" (its interface's), "kernel"
  const char* bus_state = "";       ///< of a CAN controller that has errors: "error-passive"
  bool bus_off = false;             ///< it takes part no more
  std::array<char, 160> problem{};  ///< why it is not open; zero-terminated

  void set_problem(std::string_view text) {
    problem.fill('\0');
    std::copy_n(text.begin(), std::min(text.size(), problem.size() - 1), problem.begin());
  }
};

// How each of these is judged, for the conditions "unavailable", "bus_off", "bus" and "buffer".
CheckResult check_availability(const SourceState& source);
CheckResult check_bus_off(const SourceState& source);
CheckResult check_bus_state(const SourceState& source);
CheckResult check_receive_buffer(const SourceState& source);

}  // namespace infuse::daemon
