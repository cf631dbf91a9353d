#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "drivers/measurement/stamp.hpp"

namespace infuse::vehicle {

/// Identifier of a frame.
struct CanIdentifier {
  uint32_t id = 0;  ///< 11 bits, 29 if `extended`
  bool extended = false;

  bool operator==(const CanIdentifier&) const = default;
};

/// One frame on a CAN bus: classic or FD, data, remote request or error.
struct CanFrame {
  Stamp stamp;                        ///< host receive time; zero if the source has none
  std::array<char, 16> interface {};  ///< "can0", zero-terminated; empty if unknown
  uint32_t id = 0;                    ///< 11 bits, 29 if `extended`, error class if `error`
  bool extended = false;              ///< 29-bit identifier
  bool remote = false;                ///< remote transmission request: no data
  bool error = false;                 ///< the controller's report of a bus error (SocketCAN)
  bool fd = false;                    ///< CAN FD
  uint8_t fd_flags = 0;               ///< CAN FD: 1 bit-rate switch, 2 error state indicator
  uint8_t length = 0;                 ///< bytes of data: ≤ 8, in an FD frame ≤ 64
  std::array<uint8_t, 64> data{};

  /// The frame's data bytes.
  std::span<const uint8_t> payload() const {
    return {data.data(), std::min<size_t>(length, data.size())};
  }

  /// Name of the interface without padding.
  std::string_view interface_name() const {
    const auto end = std::find(interface.begin(), interface.end(), '\0');
    return {interface.data(), static_cast<size_t>(end - interface.begin())};
  }

  /// Sets the interface's name, cut to 15 characters (Linux allows no more).
  void set_interface(std::string_view name) {
    interface.fill('\0');
    std::copy_n(name.begin(), std::min(name.size(), interface.size() - 1), interface.begin());
  }
};

}  // namespace infuse::vehicle
