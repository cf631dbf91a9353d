#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/vehicle/can_frame.hpp"
#include "drivers/vehicle/problem_log.hpp"

namespace infuse::vehicle {

/// Reads one line as candump writes it: the log format of `-l` and `-L`
/// ("(1533226488.230547) can0 260#08FF", "##" and a digit of flags for CAN FD, "#R" for a remote
/// request) or the screen format ("can0  260   [2]  08 FF"), each with or without time stamp and
/// interface; a direction ("R", "T", "RX - -") or ASCII column after it is passed over. Dates of
/// `-t A` are taken as UTC. The error's `where` is empty.
Result<CanFrame> parse_candump_line(std::string_view line);

/// The frame as candump -L writes it, without the line's end: "(1533226488.230547) can0 260#08FF".
/// Time is cut to the microsecond; an unknown interface is written as "can0".
std::string format_candump_line(const CanFrame& frame);

/// Reads a candump text line by line, keeps what is wrong in a bounded list and goes on. A frame
/// whose stamp lies before that of the frame above it is reported and handed out as it is.
class CandumpReader {
 public:
  /// `name`: what problems call the text ("can.log").
  explicit CandumpReader(std::string name) : name_(std::move(name)) {}

  /// Takes the next line, without its end; gives the frame, or nothing for a blank line, a comment
  /// ("# ...") or a line that is wrong.
  std::optional<CanFrame> read(std::string_view line);

  /// Bad lines and steps back in time.
  const ProblemLog& problems() const { return problems_; }

  uint64_t lines() const { return lines_; }
  uint64_t frames() const { return frames_; }
  uint64_t backward_steps() const { return backward_steps_; }

 private:
  void report(Error problem);

  std::string name_;
  ProblemLog problems_;
  Stamp last_ = Stamp::earliest();
  uint64_t lines_ = 0;
  uint64_t frames_ = 0;
  uint64_t backward_steps_ = 0;
};

}  // namespace infuse::vehicle
