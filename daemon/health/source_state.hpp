#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace infuse::daemon {

/// State of the interface or device of a live sensor. Plain data, copied between threads. Default
/// in a replay.
struct SourceState {
  bool open = true;                 ///< true if it can be read
  bool used = true;                 ///< false if its data is only counted
  uint32_t open_count = 0;          ///< number of times it was opened
  uint64_t buffer_requested = 0;    ///< bytes of receive buffer; 0: none
  uint64_t buffer_granted = 0;      ///< bytes granted by the kernel
  const char* stamp_source = "";    ///< of a lidar or bus: "hardware" (the interface) or "kernel"
  uint64_t unread_bytes = 0;        ///< of a serial receiver: since its last RMC or GGA sentence
  const char* bus_state = "";       ///< of a CAN controller with errors: "error-passive"
  bool bus_off = false;             ///< true if the controller no longer takes part on the bus
  std::array<char, 160> problem{};  ///< why it is not open; zero-terminated

  /// Sets `problem`, shortened to its capacity.
  void set_problem(std::string_view text) {
    problem.fill('\0');
    std::copy_n(text.begin(), std::min(text.size(), problem.size() - 1), problem.begin());
  }
};

}  // namespace infuse::daemon
