#include "daemon/pipeline/vehicle_intake.hpp"

namespace infuse::daemon {

VehicleIntake::VehicleIntake(const VehicleSetup& setup) : has_imu_(setup.imu.has_value()) {
  for (const BusSetup& bus : setup.buses) buses_.push_back({bus.decoder, {}});
}

std::optional<vehicle::CanFrame> VehicleIntake::read(std::string_view line) {
  const uint64_t frames = reader_.frames();
  auto frame = reader_.read(line);
  buses_[0].counters.refused += reader_.frames() == frames ? 1 : 0;
  return frame;
}

void VehicleIntake::count(StreamCounters& counters, Stamp stamp) {
  counters.count(stamp);
  ++counters.used;
}

void VehicleIntake::write_counters(SensorCounters& counters) const {
  for (size_t i = 0; i < buses_.size(); ++i) counters.buses[i] = buses_[i].counters;
  counters.speed = speed_;
  counters.imu = imu_;
  counters.gnss = gnss_;
}

}  // namespace infuse::daemon
