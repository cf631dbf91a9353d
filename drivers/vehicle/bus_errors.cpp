#include "drivers/vehicle/bus_errors.hpp"

#include <linux/can/error.h>

namespace infuse::vehicle {
namespace {

// CAN_ERR_CRTL_ACTIVE, missing from some kernel headers.
constexpr uint8_t kControllerActive = 0x40;

}  // namespace

const char* name_of(BusState state) {
  switch (state) {
    case BusState::kErrorActive:
      return "error-active";
    case BusState::kErrorWarning:
      return "error-warning";
    case BusState::kErrorPassive:
      return "error-passive";
    case BusState::kBusOff:
      return "bus-off";
  }
  return "";
}

void BusErrors::process(const CanFrame& frame) {
  if (!frame.error) {
    // A received frame shows that the controller is on the bus.
    if (state_ == BusState::kBusOff) state_ = BusState::kErrorActive;
    return;
  }
  if (frame.id & CAN_ERR_RESTARTED) state_ = BusState::kErrorActive;
  if (frame.id & CAN_ERR_CRTL) {
    const uint8_t controller = frame.data[1];
    if (controller & kControllerActive) state_ = BusState::kErrorActive;
    if (controller & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) {
      state_ = BusState::kErrorWarning;
    }
    if (controller & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) {
      state_ = BusState::kErrorPassive;
    }
  }
  if (frame.id & CAN_ERR_BUSOFF) state_ = BusState::kBusOff;
}

}  // namespace infuse::vehicle
