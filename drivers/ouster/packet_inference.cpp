#include "drivers/ouster/packet_inference.hpp"

#include "drivers/ouster/packet.hpp"

namespace infuse::ouster {
namespace {

/// Sensors alternate if more packets than one in so many are before their predecessor.
constexpr uint64_t kMinPacketsPerStepBack = 8;

}  // namespace

void PacketInference::add(std::span<const uint8_t> payload) {
  const auto head = read_head(payload);
  if (!head) return;
  if (packets_++ == 0) first_.assign(payload.begin(), payload.end());
  if (head->serial_number != 0) {
    other_serial_numbers_ += serial_number_ != 0 && head->serial_number != serial_number_ ? 1 : 0;
    serial_number_ = head->serial_number;
  }
  if (started_ && head->device_ns < last_ns_) ++backwards_;
  if (started_ && head->frame_id != last_frame_) {
    // The first change of frames begins the first turn that is seen whole.
    if (turns_begin_ns_ == 0) {
      turns_begin_ns_ = head->device_ns;
    } else {
      turns_ += static_cast<int16_t>(head->frame_id - last_frame_);
      turns_end_ns_ = head->device_ns;
    }
  }
  started_ = true;
  last_ns_ = head->device_ns;
  last_frame_ = head->frame_id;
}

std::string PacketInference::describe() const {
  if (packets_ == 0) return "no lidar packets";
  return "an Ouster's packets of " + std::to_string(first_.size()) +
         " bytes, which cannot be read without its metadata";
}

double PacketInference::turns_per_second() const {
  if (turns_ <= 0 || turns_end_ns_ <= turns_begin_ns_) return 0;
  return static_cast<double>(turns_) /
         (static_cast<double>(turns_end_ns_ - turns_begin_ns_) * 1e-9);
}

bool PacketInference::has_two_sensors() const {
  return other_serial_numbers_ * kMinPacketsPerStepBack > packets_ ||
         backwards_ * kMinPacketsPerStepBack > packets_;
}

bool PacketInference::fits(const Metadata& metadata) const {
  const auto packet = parse_packet(PacketLayout(metadata), first_);
  if (!packet) return false;
  return packet->serial_number == 0 || metadata.serial_number.empty() ||
         metadata.serial_number == std::to_string(packet->serial_number);
}

}  // namespace infuse::ouster
