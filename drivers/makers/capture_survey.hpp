#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "drivers/lidar/lidar_maker.hpp"
#include "drivers/makers/arrivals.hpp"
#include "drivers/measurement/datagram.hpp"
#include "drivers/measurement/ipv4_address.hpp"
#include "drivers/recording/pcap_reader.hpp"

namespace infuse::makers {

/// Datagrams of one kind from one sender to one port.
struct Stream {
  uint32_t sender = 0;                       ///< IPv4 address, host byte order
  uint16_t port = 0;                         ///< UDP destination port
  const lidar::LidarMaker* maker = nullptr;  ///< whose packets they are; null: of no known maker
  /// Their kind.
  lidar::PacketClass packet_class = lidar::PacketClass::kOther;
  Arrivals arrivals;       ///< number, times and gaps
  uint64_t bytes = 0;      ///< of payload, total
  uint64_t fixes = 0;      ///< of information packets: those with a fix of a GNSS receiver
  uint32_t last_size = 0;  ///< payload of the last datagram, bytes
  std::string statement;   ///< of information packets: what the first states of its sensor
  std::unique_ptr<lidar::ModelInference> inference;  ///< of data packets; else null

  bool has_data() const { return packet_class == lidar::PacketClass::kData; }  ///< returns
};

/// Sorts the datagrams of a capture into streams by sender, port, maker and kind.
class CaptureSurvey {
 public:
  static constexpr size_t kMaxStreams = 64;  ///< others are counted only

  /// Adds the next datagram.
  void add(const Datagram& datagram);

  /// Sets the counters of the capture's packets, for `describe_unread`.
  void set_packets(const recording::PcapCounters& packets) { packets_ = packets; }

  /// What the capture holds besides UDP datagrams: "12 packets of IPv6, which is not read; 3
  /// packets that are not UDP"; empty if there is nothing.
  std::string describe_unread() const;

  /// Streams in order of appearance.
  const std::vector<Stream>& streams() const { return streams_; }

  /// Number of datagrams of streams beyond kMaxStreams.
  uint64_t excess_datagrams() const { return excess_datagrams_; }

 private:
  Stream* stream_of(const Datagram& datagram);

  std::vector<Stream> streams_;
  uint64_t excess_datagrams_ = 0;
  recording::PcapCounters packets_;
};

}  // namespace infuse::makers
