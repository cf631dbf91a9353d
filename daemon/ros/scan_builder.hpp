#pragma once

#include <algorithm>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "drivers/ros/messages.hpp"

namespace infuse::daemon {

/// Collects the data packets of a lidar to scans of a turn.
class ScanBuilder {
 public:
  /// True if a packet that begins at this azimuth (0.01°) begins a new turn, or the scan is long
  /// enough.
  bool is_due(uint16_t azimuth, Stamp stamp) const {
    constexpr size_t kMaxPackets = 2000;
    constexpr Duration kMaxSpan{500'000'000};
    if (packets_.empty()) return false;
    const Duration span = stamp - packets_.front().stamp;
    return azimuth < azimuth_ || packets_.size() >= kMaxPackets || span > kMaxSpan ||
           span < Duration::zero();
  }
  void add(std::span<const uint8_t> payload, uint16_t azimuth, Stamp stamp) {
    azimuth_ = azimuth;
    packets_.push_back({stamp, {payload.begin(), payload.end()}});
  }
  bool empty() const { return packets_.empty(); }
  /// Forgets the packets so far.
  void clear() { packets_.clear(); }
  /// Time of the last packet.
  Stamp end() const { return packets_.back().stamp; }
  /// The packets so far as a VelodyneScan or a PandarScan, with the stamp of the first one. Begins
  /// a new scan.
  template <class Scan>
  Scan finish(const std::string& frame) {
    Scan scan{{0, ros::Time::from(packets_.front().stamp), frame}, {}};
    for (const Packet& packet : std::exchange(packets_, {})) {
      auto& message = scan.packets.emplace_back();
      message.stamp = ros::Time::from(packet.stamp);
      const size_t size = std::min(packet.bytes.size(), message.data.size());
      std::copy_n(packet.bytes.begin(), size, message.data.begin());
      if constexpr (requires { message.size; }) message.size = static_cast<uint32_t>(size);
    }
    return scan;
  }

 private:
  struct Packet {
    Stamp stamp;
    std::vector<uint8_t> bytes;
  };
  std::vector<Packet> packets_;
  uint16_t azimuth_ = 0;  // of the last packet
};

}  // namespace infuse::daemon
