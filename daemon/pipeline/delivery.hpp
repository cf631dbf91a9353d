#pragma once

#include <cstdint>

namespace infuse::daemon {

/// Behaviour of a producer whose consumer has not kept up.
enum class Delivery : uint8_t {
  kWait,       ///< replay: waits, so that nothing is lost
  kOverwrite,  ///< live: overwrites the oldest entry, which the consumer counts as lost
};

/// Live, no producer waits.
constexpr Delivery delivery_of(bool live) { return live ? Delivery::kOverwrite : Delivery::kWait; }

/// Publishes the slot in hand. `is_control`: it is not data, and a slow consumer must get it.
template <class Ring>
void deliver(Ring& ring, Delivery delivery, bool is_control = false) {
  if (delivery == Delivery::kWait) ring.wait_for_room();
  ring.publish(is_control ? Ring::Keep::kUntilRead : Ring::Keep::kNo);
}

}  // namespace infuse::daemon
