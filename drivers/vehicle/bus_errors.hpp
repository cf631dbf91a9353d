#pragma once

#include <cstdint>

#include "drivers/vehicle/can_frame.hpp"

namespace infuse::vehicle {

/// How a CAN controller is, in growing badness (ISO 11898-1).
enum class BusState : uint8_t {
  kErrorActive,   ///< takes part
  kErrorWarning,  ///< many errors
  kErrorPassive,  ///< error-passive: no longer destroys the frames of others
  kBusOff,        ///< takes part no more until it is restarted
};

/// "error-active", "error-warning", "error-passive", "bus-off".
const char* name_of(BusState state);

/// What a controller's error frames have said (SocketCAN: linux/can/error.h).
class BusErrors {
 public:
  /// Takes a frame; one that is no error frame says nothing, but that the bus is not off.
  void process(const CanFrame& frame);

  /// The interface went down or came up: the controller begins anew.
  void reset() { state_ = BusState::kErrorActive; }

  BusState state() const { return state_; }
  uint64_t error_frames() const { return error_frames_; }
  uint64_t bus_offs() const { return bus_offs_; }
  uint64_t overruns() const { return overruns_; }  ///< of the controller's own receive buffer

 private:
  BusState state_ = BusState::kErrorActive;
  uint64_t error_frames_ = 0;
  uint64_t bus_offs_ = 0;
  uint64_t overruns_ = 0;
};

}  // namespace infuse::vehicle
