#pragma once

#include <optional>
#include <string_view>

#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// What a page of a replay asks for, and that one has been opened.
struct ViewCommand {
  enum class Kind {
    kOpened,     ///< a page or a viewer has been opened: begin
    kRate,       ///< `rate`
    kStep,       ///< on by one sweep, then pause
    kSeek,       ///< on to `stamp`, as fast as possible
    kSeekAlert,  ///< on to the next alert, as fast as possible, then pause
  };
  static constexpr double kMaxRate = 100;

  Kind kind = Kind::kRate;
  double rate = 1;  ///< multiple of real time, 0 … kMaxRate; 0 pauses
  Stamp stamp;      ///< drive time

  bool operator==(const ViewCommand&) const = default;
};

/// Reads a command: `{"rate":R}`, `{"step":true}`, `{"seek":"NS"}` (ns as text: they exceed the
/// integers of JavaScript) or `{"seek":"alert"}`. Nothing for every other text.
std::optional<ViewCommand> parse_view_command(std::string_view text);

/// Reads `{"profiles":true}` or `false`: whether a page shows dependence profiles. It changes what
/// is sent to that page, and nothing else. Nothing for every other text.
std::optional<bool> parse_profiles_wanted(std::string_view text);

}  // namespace infuse::daemon
