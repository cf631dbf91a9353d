#pragma once

#include <cstdint>

namespace infuse::daemon {

/// Behaviour of a producer whose consumer has not kept up.
enum class Delivery : uint8_t {
  kWait,       ///< replay: waits, so that nothing is lost
  kOverwrite,  ///< live: overwrites the oldest entry, which the consumer counts as lost
};

/// Publishes the slot in hand.
template <class Ring>
void deliver(Ring& ring, Delivery delivery) {
  if (delivery == Delivery::kWait) ring.wait_for_room();
  ring.publish();
}

}  // namespace infuse::daemon
