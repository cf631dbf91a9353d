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

/// Filter of a capture's datagrams, and limits of fragment reassembly.
struct PcapOptions {
  std::vector<uint16_t> ports;                ///< UDP destination ports; empty: all
  std::vector<uint32_t> senders;              ///< IPv4 addresses, host byte order; empty: all
  size_t max_fragmented_datagrams = 16;       ///< reassembled at the same time, 64 KiB each
  Duration fragment_timeout{30'000'000'000};  ///< incomplete datagrams older than this are dropped

  /// Returns what is invalid, if anything.
  std::optional<std::string> invalid() const;
};

/// Packet counters of a capture. Checksums are not verified, because captures made on the sending
/// host contain incomplete ones.
struct PcapCounters {
  uint64_t packets = 0;            ///< read from the file
  uint64_t datagrams = 0;          ///< returned
  uint64_t filtered = 0;           ///< complete UDP datagrams excluded by the options
  uint64_t ipv6 = 0;               ///< IPv6, but not UDP: neighbour discovery …
  uint64_t not_udp = 0;            ///< ARP, TCP … of IPv4
  uint64_t truncated = 0;          ///< captured with a short snapshot length (tcpdump -s)
  uint64_t malformed = 0;          ///< with contradictory lengths
  uint64_t fragments = 0;          ///< IP fragments seen
  uint64_t fragments_dropped = 0;  ///< IP fragments of datagrams that were never complete
  uint64_t skipped_bytes = 0;      ///< that are no packets
};

/// Reads the UDP datagrams of a pcap or pcapng file, plain or compressed (gzip, zstd):
/// Ethernet with or without VLAN tags (802.1Q, QinQ), Linux cooked v1 and v2, raw IP, BSD loopback;
/// IP fragments are reassembled. After a damaged record of an uncompressed pcap file reading goes
/// on at the next sound one. Where the host's clock was set back, stamps run on. Allocates nothing
/// after `open` unless the file is damaged.
class PcapReader {
 public:
  /// Opens a capture. Fails if the file cannot be read, is not a capture, or has another link type.
  static Result<PcapReader> open(const std::filesystem::path& path,
                                 const PcapOptions& options = {});

  /// Opens a capture in memory, which must outlive the reader. `name` replaces the path in errors.
  static Result<PcapReader> from_bytes(std::span<const uint8_t> bytes, const std::string& name,
                                       const PcapOptions& options = {});

  PcapReader(PcapReader&&) noexcept;             ///< movable
  PcapReader& operator=(PcapReader&&) noexcept;  ///< movable
  ~PcapReader();

  /// Reads the next datagram that passes the filter; its payload is valid until the next call.
  /// Returns false at the end of the file, or where it is damaged (see `damage`).
  bool next(Datagram& datagram);

  /// Damage that ended reading early, with packet number and byte offset. Empty if there is none.
  const std::optional<Error>& damage() const;

  /// Problems so far, for display: the damage, and packets that are cut short or malformed.
  void append_notes(std::vector<Error>& notes) const;

  /// Counters of the packets read so far.
  const PcapCounters& counters() const;

 private:
  struct State;
  explicit PcapReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace infuse::recording
