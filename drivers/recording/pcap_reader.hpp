#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/measurement/datagram.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::recording {

/// Which datagrams of a capture are handed out, and how much may wait for missing fragments.
struct PcapOptions {
  std::vector<uint16_t> ports;           ///< UDP destination ports; empty: all
  std::vector<uint32_t> senders;         ///< IPv4 addresses, host byte order; empty: all
  size_t max_fragmented_datagrams = 16;  ///< put together at the same time, 64 KiB each
  Duration fragment_timeout{
      30'000'000'000};  ///< ns; a datagram that is not whole by then is dropped

  /// What is wrong with the options, or nothing.
  std::optional<std::string> invalid() const;
};

/// What became of the packets of a capture. Checksums are not verified: a capture on the sending
/// host holds unfinished ones.
struct PcapCounters {
  uint64_t packets = 0;    ///< read from the file
  uint64_t datagrams = 0;  ///< handed out
  uint64_t filtered = 0;   ///< whole UDP datagrams that the options leave out
  uint64_t not_udp = 0;    ///< ARP, TCP, IPv6 …
  uint64_t truncated = 0;  ///< captured short (tcpdump -s): the rest of the datagram is lost
  uint64_t malformed = 0;  ///< lengths that contradict each other
  uint64_t fragments = 0;  ///< IPv4 fragments seen
  uint64_t fragments_dropped = 0;  ///< of these, such as never became whole
};

/// Reads the UDP datagrams of a pcap or pcapng file (micro- or nanoseconds, either byte order):
/// Ethernet with or without VLAN tags (802.1Q, QinQ), Linux cooked v1 and v2, raw IP, BSD loopback;
/// IPv4 fragments are put together. Allocates nothing after `open`.
class PcapReader {
 public:
  /// Fails where the file cannot be read, is no capture, or has a link type other than those.
  static Result<PcapReader> open(const std::filesystem::path& path,
                                 const PcapOptions& options = {});

  /// The same from memory, which must outlive the reader; `name` stands for the path in errors.
  static Result<PcapReader> from_bytes(std::span<const uint8_t> bytes, const std::string& name,
                                       const PcapOptions& options = {});

  PcapReader(PcapReader&&) noexcept;
  PcapReader& operator=(PcapReader&&) noexcept;
  ~PcapReader();

  /// The next datagram that passes the filter; its payload is valid until the next call. False at
  /// the end: of the file, or of what can be read of it (then `damage` says so).
  bool next(Datagram& datagram);

  /// Why reading ended before the file did: packet number and byte offset. Empty while the file is
  /// sound.
  const std::optional<Error>& damage() const;

  const PcapCounters& counters() const;

 private:
  struct State;
  explicit PcapReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace infuse::recording
