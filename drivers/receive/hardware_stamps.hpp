#pragma once

#include <cstdint>

#include "drivers/measurement/clock_model.hpp"

namespace infuse::receive {

/// Brings the stamps of an interface's own clock onto the time base by watching when its messages
/// arrive. That clock counts from anywhere and runs at its own rate; what it says is free of the
/// delays of the interface's bus and of this host, but for the least of them.
class HardwareStamps {
 public:
  HardwareStamps();

  /// The stamp of a message that the interface stamped `hardware_ns` and the kernel `received`; 0:
  /// the interface did not stamp it. Never later than `received`, never before the last.
  Stamp update(int64_t hardware_ns, Stamp received);

  /// Whether the last message had a stamp of the interface.
  bool stamped_by_hardware() const { return stamped_by_hardware_; }

 private:
  ClockModel clock_;
  Stamp last_ = Stamp::earliest();
  bool stamped_by_hardware_ = false;
};

}  // namespace infuse::receive
