#pragma once

#include <algorithm>
#include <span>
#include <string>
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
    const Duration span = stamp - packets_.front().stamp.stamp();
    return azimuth < azimuth_ || packets_.size() >= kMaxPackets || span > kMaxSpan ||
           span < Duration::zero();
  }
  void add(std::span<const uint8_t> payload, uint16_t azimuth, Stamp stamp) {
    azimuth_ = azimuth;
    ros::VelodynePacket& packet = packets_.emplace_back();
    packet.stamp = ros::Time::from(stamp);
    std::ranges::copy(payload, packet.data.begin());
  }
  bool empty() const { return packets_.empty(); }
  /// Forgets the packets so far.
  void clear() { packets_.clear(); }
  /// Time of the last packet.
  Stamp end() const { return packets_.back().stamp.stamp(); }
  /// The packets so far, with the stamp of the first one. Begins a new scan.
  ros::VelodyneScan finish(const std::string& frame) {
    ros::VelodyneScan scan{{0, packets_.front().stamp, frame}, std::move(packets_)};
    packets_.clear();
    return scan;
  }

 private:
  std::vector<ros::VelodynePacket> packets_;
  uint16_t azimuth_ = 0;  // of the last packet
};

}  // namespace infuse::daemon
