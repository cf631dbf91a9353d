#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "drivers/measurement/datagram.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::recording {

/// Writes datagrams as Ethernet, IPv4, UDP into a pcap file with nanosecond stamps, as tcpdump
/// would have. Allocates nothing after `create`.
class PcapWriter {
 public:
  /// Creates or overwrites the file.
  static Result<PcapWriter> create(const std::filesystem::path& path);

  PcapWriter(PcapWriter&&) noexcept;
  PcapWriter& operator=(PcapWriter&&) noexcept;
  /// Closes without a word; call `close` to know whether all of it reached the disk.
  ~PcapWriter();

  /// Appends one datagram, addressed to `receiver` (IPv4, host byte order). Fails where the payload
  /// is longer than 65507 bytes, the stamp lies outside 1970 … 2106, or the disk is full.
  Result<void> write(const Datagram& datagram, uint32_t receiver = 0xFFFF'FFFF);

  /// Bytes written so far, headers included.
  uint64_t bytes() const;

  /// Hands all that was written to the system. Where that fails the file is cut back to what was
  /// whole at the last flush, and closed.
  Result<void> flush();

  /// Flushes and closes. The writer accepts nothing afterwards.
  Result<void> close();

 private:
  struct State;
  explicit PcapWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace infuse::recording
