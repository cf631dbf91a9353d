#pragma once

#include <pcap/pcap.h>

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include "drivers/measurement/datagram.hpp"

namespace infuse {

/// One UDP datagram of a capture.
struct CapturedDatagram {
  Stamp stamp;
  uint32_t sender = 0;
  uint16_t port = 0;  ///< destination
  std::vector<uint8_t> payload;

  Datagram datagram() const { return {stamp, sender, 0, port, payload}; }
};

/// The UDP datagrams of a plain capture (Ethernet, IPv4, no fragments), for tests that must not
/// depend on the reader that the product uses. Throws where the file cannot be opened.
inline std::vector<CapturedDatagram> read_capture(const std::filesystem::path& path) {
  char error[PCAP_ERRBUF_SIZE];
  pcap_t* capture =
      pcap_open_offline_with_tstamp_precision(path.c_str(), PCAP_TSTAMP_PRECISION_NANO, error);
  if (capture == nullptr) throw std::runtime_error(error);
  std::vector<CapturedDatagram> datagrams;
  pcap_pkthdr* header = nullptr;
  const u_char* bytes = nullptr;
  while (pcap_next_ex(capture, &header, &bytes) == 1) {
    constexpr size_t kEthernet = 14;
    constexpr size_t kUdp = 8;
    if (header->caplen < kEthernet + 20 + kUdp || bytes[12] != 8 || bytes[23] != 17) continue;
    const size_t ip = size_t{4} * (bytes[kEthernet] & 15);
    const u_char* udp = bytes + kEthernet + ip;
    const u_char* end = bytes + header->caplen;
    if (udp + kUdp > end) continue;
    CapturedDatagram datagram;
    datagram.stamp =
        Stamp::from_ns(int64_t{header->ts.tv_sec} * 1'000'000'000 + header->ts.tv_usec);
    for (size_t i = 0; i < 4; ++i) datagram.sender = datagram.sender << 8 | bytes[26 + i];
    datagram.port = static_cast<uint16_t>(udp[2] << 8 | udp[3]);
    datagram.payload.assign(udp + kUdp, end);
    datagrams.push_back(std::move(datagram));
  }
  pcap_close(capture);
  return datagrams;
}

}  // namespace infuse
