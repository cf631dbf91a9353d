#pragma once

#include <cstdint>

#include "drivers/vehicle/can_frame.hpp"

namespace infuse::vehicle {

/// State of a CAN controller, from good to bad (ISO 11898-1).
enum class BusState : uint8_t {
  kErrorActive,   ///< normal operation
  kErrorWarning,  ///< many errors
  kErrorPassive,  ///< error-passive: no longer destroys the frames of others
  kBusOff,        ///< disconnected until it is restarted
};

/// "error-active", "error-warning", "error-passive", "bus-off".
const char* name_of(BusState state);

/// State of a bus from its controller's error frames (SocketCAN: linux/can/error.h).
class BusErrors {
 public:
  /// Processes a frame; one that is not an error frame only shows that the bus is not off.
  void process(const CanFrame& frame);

  /// Resets the state after the interface went down or up, which restarts the controller.
  void reset() { state_ = BusState::kErrorActive; }

  BusState state() const { return state_; }

 private:
  BusState state_ = BusState::kErrorActive;
};

}  // namespace infuse::vehicle
