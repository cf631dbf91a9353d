#pragma once

#include <cstdint>

namespace infuse::daemon {

/// What a stage does where the next one has not kept up.
enum class Delivery : uint8_t {
  kWait,       ///< a replay: waits, so that nothing is lost
  kOverwrite,  ///< live: goes on; the oldest is lost, and whoever was too slow knows it
};

/// Publishes what is in hand.
template <class Ring>
void deliver(Ring& ring, Delivery delivery) {
  if (delivery == Delivery::kWait) ring.wait_for_room();
  ring.publish();
}

}  // namespace infuse::daemon
