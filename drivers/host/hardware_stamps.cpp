#include "drivers/host/hardware_stamps.hpp"

#include <algorithm>

namespace infuse::host {
namespace {

/// The counter of an interface restarts only with the interface. A loaded host may be late by tens
/// of milliseconds, which is not a jump of that clock.
ClockModelOptions interface_clock_options() {
  ClockModelOptions options;
  options.modulo = Duration::zero();
  options.jump_threshold = Duration(200'000'000);
  return options;
}

}  // namespace

HardwareStamps::HardwareStamps() : clock_(interface_clock_options()) {}

Stamp HardwareStamps::update(int64_t hardware_ns, Stamp received, uint32_t interface) {
  stamped_by_hardware_ = hardware_ns > 0;
  if (stamped_by_hardware_ && interface != interface_) {
    clock_ = ClockModel(interface_clock_options());
    interface_ = interface;
  }
  const Stamp stamp =
      stamped_by_hardware_ ? clock_.update(Duration(hardware_ns), received) : received;
  last_ = std::min(std::max(stamp, last_), received);
  return last_;
}

}  // namespace infuse::host
