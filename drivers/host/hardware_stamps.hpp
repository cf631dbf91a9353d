#pragma once

#include <cstdint>

#include "drivers/measurement/clock_model.hpp"

namespace infuse::host {

/// Maps the hardware stamps of a network or CAN interface onto the time base, from the arrival
/// times of its messages. The interface's clock has an arbitrary origin and its own rate. Its
/// stamps are free of the varying delays of the interface's bus and of this host; the minimum delay
/// remains.
class HardwareStamps {
 public:
  HardwareStamps();

  /// Returns the stamp of a message that the interface stamped `hardware_ns` (0: not stamped) and
  /// the kernel `received`. Never later than `received`, never before the previous stamp.
  /// `interface`: index of the interface, 0 if unknown: each has a clock of its own, and messages
  /// of another one begin anew.
  Stamp update(int64_t hardware_ns, Stamp received, uint32_t interface = 0);

  /// True if the last message had a hardware stamp.
  bool stamped_by_hardware() const { return stamped_by_hardware_; }

 private:
  ClockModel clock_;
  uint32_t interface_ = 0;
  Stamp last_ = Stamp::earliest();
  bool stamped_by_hardware_ = false;
};

}  // namespace infuse::host
