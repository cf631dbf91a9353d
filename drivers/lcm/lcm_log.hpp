#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::lcm {

/// One message of a log. Channel and data lie in the file's bytes.
struct LcmEvent {
  uint64_t number = 0;  ///< counts the events of the log
  Stamp time;           ///< when it was logged, to 1 µs
  std::string_view channel;
  std::span<const uint8_t> data;
};

/// What a log contained besides sound events.
struct LcmCounters {
  uint64_t events = 0;
  uint64_t damaged_places = 0;  ///< where events were lost
  uint64_t skipped_bytes = 0;   ///< there
  uint64_t missing_events = 0;  ///< by the numbers of the events before and after these places
};

/// Reads a log of LCM in memory in the order in which it was written. Allocates nothing per event;
/// the work is linear in the size of the file, whatever it contains.
class LcmReader {
 public:
  /// Opens a file in memory, which must outlive the reader. `name` is that of the file in errors.
  /// Fails if there is no event in its first 16 MiB.
  static Result<LcmReader> open(std::span<const uint8_t> bytes, const std::string& name);

  /// Reads the next event. Returns false at the end.
  bool next(LcmEvent& event);

  /// Counters of the events read so far.
  const LcmCounters& counters() const { return counters_; }

  /// Appends what was wrong with the file so far, for display.
  void append_notes(std::vector<Error>& notes) const;

 private:
  LcmReader(std::span<const uint8_t> bytes, std::string name)
      : bytes_(bytes), name_(std::move(name)) {}
  void skip_to(size_t position);

  std::span<const uint8_t> bytes_;
  std::string name_;
  size_t position_ = 0;
  size_t first_damage_ = 0;  ///< position
  std::optional<uint64_t> last_number_;
  bool after_damage_ = false;
  bool is_cut_ = false;
  LcmCounters counters_;
};

}  // namespace infuse::lcm
