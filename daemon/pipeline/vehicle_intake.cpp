#include "daemon/pipeline/vehicle_intake.hpp"

namespace infuse::daemon {

std::optional<vehicle::CanFrame> VehicleIntake::read(std::string_view line) {
  const uint64_t frames = reader_.frames();
  auto frame = reader_.read(line);
  can_.refused += reader_.frames() == frames ? 1 : 0;
  return frame;
}

void VehicleIntake::count(StreamCounters& counters, Stamp stamp) {
  counters.count(stamp);
  ++counters.used;
}

}  // namespace infuse::daemon
