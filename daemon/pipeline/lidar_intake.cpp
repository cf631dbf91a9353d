#include "daemon/pipeline/lidar_intake.hpp"

#include "drivers/lidar/lidar_maker.hpp"

namespace infuse::daemon {

LidarIntake::LidarIntake(const LidarSetup& setup) {
  if (setup.has_packets) decoder_ = lidar::make_decoder(setup.decoder).value();
}

void LidarIntake::push(const Datagram& datagram) {
  decoder_->push(datagram);
  if (decoder_->counters().packets > counters_.packets) note_packet(datagram.stamp);
  copy_counters();
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
