#include "daemon/pipeline/vehicle_intake.hpp"

namespace infuse::daemon {

VehicleIntake::VehicleIntake(const VehicleSetup& setup)
    : has_speed_(setup.has_speed), has_imu_(setup.has_imu), has_gnss_(setup.has_gnss) {
  for (const auto& decoder : setup.buses) buses_.push_back({decoder, {}});
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

void VehicleIntake::write_counters(StreamCounters* first) const {
  for (const Bus& bus : buses_) *first++ = bus.counters;
  if (has_speed_) *first++ = speed_;
  if (has_imu_) *first++ = imu_;
  if (has_gnss_) *first++ = gnss_;
}

}  // namespace infuse::daemon
