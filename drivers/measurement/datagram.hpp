#pragma once

#include <cstdint>
#include <span>

#include "drivers/measurement/stamp.hpp"

namespace infuse {

/// One UDP datagram, live or from a recording. Its source owns the payload, which is valid until
/// the next datagram is requested.
struct Datagram {
  Stamp stamp;          ///< host receive time
  uint32_t sender = 0;  ///< IPv4 address, host byte order
  uint16_t sender_port = 0;
  uint16_t destination_port = 0;
  std::span<const uint8_t> payload;
};

}  // namespace infuse
