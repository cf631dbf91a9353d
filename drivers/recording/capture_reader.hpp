#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/recording/pcap_reader.hpp"

namespace infuse::recording {

/// Reads the UDP datagrams of a recording that is one capture or several (`find_capture_parts`).
/// The parts are read in order of their first stamps, whatever their names. Parts that overlap are
/// merged by time. Gaps between parts, overlaps and unreadable parts are named in the notes.
/// Allocates only where a part begins.
class CaptureReader {
 public:
  /// Maximum number of parts that are read at the same time because they overlap.
  static constexpr size_t kMaxOverlapping = 8;

  /// Opens a recording. Fails if no part can be read.
  static Result<CaptureReader> open(const std::filesystem::path& path,
                                    const PcapOptions& options = {});

  /// Reads the next datagram that passes the filter; its payload is valid until the next call.
  /// Returns false at the end.
  bool next(Datagram& datagram);

  /// Problems so far, for display.
  void append_notes(std::vector<Error>& notes) const;

  /// Counters of the packets read so far, of all parts.
  PcapCounters counters() const;

  /// Number of files that are read.
  size_t parts() const { return parts_.size(); }

 private:
  struct Part {
    std::filesystem::path path;
    Stamp first;  ///< of its datagrams; latest if it has none
  };
  /// A part that is being read.
  struct OpenPart {
    size_t index = 0;  ///< in `parts_`
    PcapReader reader;
    Datagram head;  ///< the next datagram to return
    Stamp last;     ///< latest stamp so far
  };

  CaptureReader() = default;
  static Result<CaptureReader> open_parts(const std::vector<std::filesystem::path>& files,
                                          const PcapOptions& options);
  void open_next_part();
  bool advance(OpenPart& part);
  void close(size_t i);
  void note_gap(const OpenPart& next);
  void note_overlaps(const OpenPart& ended);
  void note(std::string what, std::string where, std::string hint);

  PcapOptions options_;
  std::vector<Part> parts_;
  size_t next_part_ = 0;
  std::vector<OpenPart> open_;
  std::optional<size_t> current_;  ///< in `open_`: whose head was returned by `next`
  std::vector<Error> notes_;
  size_t notes_left_out_ = 0;
  PcapCounters closed_;  ///< of the parts that are closed

  // Of what was read so far: its end, the part it belongs to, the longest gap within parts.
  std::optional<Stamp> end_;
  size_t end_part_ = 0;
  Duration longest_gap_{0};
};

}  // namespace infuse::recording
