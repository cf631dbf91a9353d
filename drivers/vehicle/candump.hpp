#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/vehicle/can_frame.hpp"
#include "drivers/vehicle/problem_log.hpp"

namespace infuse::vehicle {

/// Parses one line as candump writes it: the log format of `-l` and `-L` ("(1533226488.230547) can0
/// 260#08FF", "##" and a digit of flags for CAN FD, "#R" for a remote request) or the screen format
/// ("can0  260   [2]  08 FF"), each with or without time stamp and interface. A direction ("R",
/// "T", "RX - -") and the ASCII column are skipped. Dates of `-t A` are read as UTC. The error's
/// `where` is empty.
Result<CanFrame> parse_candump_line(std::string_view line);

/// Formats the frame as candump -L does, without line end: "(1533226488.230547) can0 260#08FF". The
/// time is truncated to the microsecond; an unknown interface is written as "can0".
std::string format_candump_line(const CanFrame& frame);

/// Reads candump text line by line, collects problems in a bounded list and continues. A frame
/// whose stamp is earlier than the previous one is reported and returned unchanged.
class CandumpReader {
 public:
  /// `name`: name of the text in problem reports ("can.log").
  explicit CandumpReader(std::string name) : name_(std::move(name)) {}

  /// Parses the next line, without its end. Returns the frame, or nothing for a blank line, a
  /// comment ("# ...") or a malformed line.
  std::optional<CanFrame> read(std::string_view line);

  /// Malformed lines and steps back in time.
  const ProblemLog& problems() const { return problems_; }

  uint64_t lines() const { return lines_; }
  uint64_t frames() const { return frames_; }

 private:
  void report(Error problem);

  std::string name_;
  ProblemLog problems_;
  Stamp last_ = Stamp::earliest();
  uint64_t lines_ = 0;
  uint64_t frames_ = 0;
};

}  // namespace infuse::vehicle
