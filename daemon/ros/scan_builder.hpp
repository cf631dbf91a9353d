#pragma once

#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "drivers/ros/messages.hpp"
#include "drivers/velodyne/packet.hpp"

namespace infuse::daemon {

/// Collects the data packets of a lidar to scans of a turn.
class ScanBuilder {
 public:
  /// True if the packet begins a new turn, or the scan is long enough.
  bool is_due(std::span<const uint8_t> payload, Stamp stamp) const {
    constexpr size_t kMaxPackets = 2000;
    constexpr Duration kMaxSpan{500'000'000};
    if (packets_.empty()) return false;
    const Duration span = stamp - packets_.front().stamp.stamp();
    return azimuth_of(payload) < azimuth_of(packets_.back().data) ||
           packets_.size() >= kMaxPackets || span > kMaxSpan || span < Duration::zero();
  }
  void add(std::span<const uint8_t> payload, Stamp stamp) {
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
  static uint16_t azimuth_of(std::span<const uint8_t> payload) {
    return velodyne::read_u16(payload.data() + 2);
  }
  std::vector<ros::VelodynePacket> packets_;
};

}  // namespace infuse::daemon
