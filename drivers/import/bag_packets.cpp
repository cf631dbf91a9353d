#include "drivers/import/bag_packets.hpp"

#include <algorithm>
#include <array>

#include "drivers/ros/messages.hpp"

namespace infuse::importers {
namespace {

using OnPacket = std::function<void(Stamp, std::span<const uint8_t>)>;

Stamp stamp_or(const ros::Time& time, Stamp other) {
  const Stamp stamp = time.stamp();
  return stamp == Stamp() ? other : stamp;
}

// What the messages hold.

void for_each_packet(const ros::PandarScan& scan, Stamp log_time, const OnPacket& on_packet) {
  const Stamp begin = stamp_or(scan.header.stamp, log_time);
  for (const ros::PandarPacket& packet : scan.packets) {
    const size_t size = std::min<size_t>(packet.size, packet.data.size());
    on_packet(stamp_or(packet.stamp, begin), std::span(packet.data).first(size));
  }
}

/// Scans whose packets are a stamp and bytes.
template <class Scan>
void for_each_packet(const Scan& scan, Stamp log_time, const OnPacket& on_packet) {
  const Stamp begin = stamp_or(scan.header.stamp, log_time);
  for (const auto& packet : scan.packets) on_packet(stamp_or(packet.stamp, begin), packet.data);
}

void for_each_packet(const ros::RslidarPacket& packet, Stamp log_time, const OnPacket& on_packet) {
  on_packet(stamp_or(packet.header.stamp, log_time), packet.data);
}

void for_each_packet(const ros::OldRslidarPacket& packet, Stamp log_time,
                     const OnPacket& on_packet) {
  on_packet(stamp_or(packet.stamp, log_time), packet.data);
}

void for_each_packet(const ros::OusterPacket& packet, Stamp log_time, const OnPacket& on_packet) {
  on_packet(log_time, packet.buffer);
}

template <class T>
bool read_as(const BagMessage& message, const OnPacket& on_packet) {
  const auto read = ros::decode<T>(message.data, message.encoding);
  if (!read) return false;
  for_each_packet(*read, message.log_time, on_packet);
  return true;
}

struct PacketMessage {
  const char* type;
  bool (*read)(const BagMessage& message, const OnPacket& on_packet);
};

constexpr std::array<PacketMessage, 10> kPacketMessages{{
    {ros::VelodyneScan::kName, read_as<ros::VelodyneScan>},
    {ros::PandarScan::kName, read_as<ros::PandarScan>},
    {"hesai_lidar/msg/PandarScan", read_as<ros::PandarScan>},
    {ros::NebulaPackets::kName, read_as<ros::NebulaPackets>},
    {ros::RslidarPacket::kName, read_as<ros::RslidarPacket>},
    {"rslidar_msgs/msg/rslidarScan", read_as<ros::OldRslidarScan>},
    {"rslidar_msgs/msg/rslidarPacket", read_as<ros::OldRslidarPacket>},
    {ros::OusterPacket::kName, read_as<ros::OusterPacket>},
    {"ouster_ros/msg/PacketMsg", read_as<ros::OusterPacket>},
    {"ouster_msgs/msg/PacketMsg", read_as<ros::OusterPacket>},
}};

const PacketMessage* find_message(std::string_view type) {
  const auto found = std::ranges::find_if(
      kPacketMessages, [&](const PacketMessage& message) { return type == message.type; });
  return found == kPacketMessages.end() ? nullptr : &*found;
}

}  // namespace

bool holds_packets(std::string_view type) { return find_message(type) != nullptr; }

bool read_packets(const BagMessage& message, const OnPacket& on_packet) {
  const PacketMessage* found = find_message(message.type);
  return found != nullptr && found->read(message, on_packet);
}

}  // namespace infuse::importers
