#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "drivers/measurement/stamp.hpp"

namespace infuse::vehicle {

/// What a frame is known by.
struct CanIdentifier {
  uint32_t id = 0;  ///< 11 bits, 29 where `extended`
  bool extended = false;

  bool operator==(const CanIdentifier&) const = default;
};

/// One frame on a CAN bus: classic or FD, data, remote request or error.
struct CanFrame {
  Stamp stamp;                        ///< host receive time; zero where the source has none
  std::array<char, 16> interface {};  ///< "can0", zero-terminated; empty where unknown
  uint32_t id = 0;                    ///< 11 bits, 29 where `extended`, error class where `error`
  bool extended = false;              ///< 29-bit identifier
  bool remote = false;                ///< remote transmission request: no data
  bool error = false;                 ///< the controller's report of a bus error (SocketCAN)
  bool fd = false;                    ///< CAN FD
  uint8_t fd_flags = 0;               ///< CAN FD: 1 bit-rate switch, 2 error state indicator
  uint8_t length = 0;                 ///< bytes of data: ≤ 8, in an FD frame ≤ 64
  std::array<uint8_t, 64> data{};

  /// The bytes that the frame carries.
  std::span<const uint8_t> payload() const {
    return {data.data(), std::min<size_t>(length, data.size())};
  }

  /// The name of the interface, without its padding.
  std::string_view interface_name() const {
    const auto end = std::find(interface.begin(), interface.end(), '\0');
    return {interface.data(), static_cast<size_t>(end - interface.begin())};
  }

  /// Sets the interface's name; what is longer than 15 characters (Linux allows no more) is cut.
  void set_interface(std::string_view name) {
    interface.fill('\0');
    std::copy_n(name.begin(), std::min(name.size(), interface.size() - 1), interface.begin());
  }
};

}  // namespace infuse::vehicle
