#include "daemon/pipeline/lidar_intake.hpp"

#include "drivers/lidar/lidar_maker.hpp"

namespace infuse::daemon {

LidarIntake::LidarIntake(const LidarSetup& setup)
    : R_vehicle_lidar_(setup.T_vehicle_lidar.linear()) {
  if (setup.has_packets) decoder_ = lidar::make_decoder(setup.decoder).value();
}

void LidarIntake::push(const Datagram& datagram) {
  decoder_->push(datagram);
  if (decoder_->counters().packets > counters_.packets) note_packet(datagram.stamp);
  copy_counters();
}

ImuSample LidarIntake::to_vehicle(const ImuSample& sample) const {
  ImuSample turned = sample;
  Eigen::Map<Eigen::Vector3d>(turned.angular_velocity.data()) =
      R_vehicle_lidar_ * Eigen::Vector3d(sample.angular_velocity.data());
  Eigen::Map<Eigen::Vector3d>(turned.linear_acceleration.data()) =
      R_vehicle_lidar_ * Eigen::Vector3d(sample.linear_acceleration.data());
  return turned;
}

void LidarIntake::copy_counters() {
  static_cast<lidar::PacketCounters&>(counters_) = decoder_->counters();
  counters_.clock = decoder_->clock();
}

void LidarIntake::add_kernel_dropped(uint64_t datagrams, bool data) {
  decoder_->add_kernel_dropped(datagrams, data);
  copy_counters();
}

void LidarIntake::add_filtered(uint64_t datagrams) {
  decoder_->add_filtered(datagrams);
  copy_counters();
}

void LidarIntake::note_packet(Stamp stamp) {
  if (counters_.packets == 0) counters_.first_packet = stamp;
  counters_.last_packet = stamp;
}

}  // namespace infuse::daemon
