#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "drivers/measurement/datagram.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::recording {

/// Writes datagrams as Ethernet, IPv4 and UDP to a pcap file with nanosecond stamps, as tcpdump
/// does. Allocates nothing after `create`.
class PcapWriter {
 public:
  /// Creates or overwrites the file.
  static Result<PcapWriter> create(const std::filesystem::path& path);

  PcapWriter(PcapWriter&&) noexcept;
  PcapWriter& operator=(PcapWriter&&) noexcept;
  /// Closes the file; errors are ignored. Call `close` to detect them.
  ~PcapWriter();

  /// Appends one datagram, addressed to `receiver` (IPv4, host byte order). Fails if the payload is
  /// longer than 65507 bytes, the stamp is outside 1970 … 2106, or the disk is full.
  Result<void> write(const Datagram& datagram, uint32_t receiver = 0xFFFF'FFFF);

  /// Number of bytes written, including headers.
  uint64_t bytes() const;

  /// Writes buffered packets to the file. If that fails, the file is truncated to its size after
  /// the last flush and closed.
  Result<void> flush();

  /// Flushes and closes the file. Later writes fail.
  Result<void> close();

 private:
  struct State;
  explicit PcapWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace infuse::recording
