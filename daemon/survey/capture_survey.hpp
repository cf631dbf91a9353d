#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "daemon/survey/arrivals.hpp"
#include "drivers/measurement/datagram.hpp"
#include "drivers/velodyne/model_inference.hpp"

namespace infuse::daemon {

/// What a stream's datagrams look like.
enum class StreamKind : uint8_t {
  kData,      ///< 1206 bytes: a Velodyne's returns
  kPosition,  ///< 512 bytes: its clock, PPS and NMEA
  kOther,
};

/// Datagrams from one sender to one port.
struct Stream {
  uint32_t sender = 0;  ///< IPv4 address, host byte order
  uint16_t port = 0;    ///< UDP destination port
  StreamKind kind = StreamKind::kOther;
  Arrivals arrivals;
  uint64_t bytes = 0;                  ///< of payload
  uint32_t last_size = 0;              ///< payload of the last one, bytes
  velodyne::ModelInference inference;  ///< of kData
};

/// Sorts the datagrams of a capture into streams.
class CaptureSurvey {
 public:
  static constexpr size_t kMaxStreams = 64;

  void add(const Datagram& datagram);

  /// In order of appearance.
  const std::vector<Stream>& streams() const { return streams_; }

  /// Datagrams of streams beyond kMaxStreams.
  uint64_t excess_datagrams() const { return excess_datagrams_; }

 private:
  Stream* stream_of(const Datagram& datagram);

  std::vector<Stream> streams_;
  uint64_t excess_datagrams_ = 0;
};

/// "10.0.0.7".
std::string address_text(uint32_t address);

/// Four numbers and three points, to host byte order; nothing where it is anything else.
std::optional<uint32_t> parse_address(const std::string& text);

}  // namespace infuse::daemon
