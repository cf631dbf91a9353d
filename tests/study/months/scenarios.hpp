#pragma once

#include <ostream>
#include <span>
#include <string>
#include <vector>

#include "tests/study/months/simulation.hpp"

namespace infuse::study {

/// What happens to a vehicle, and what the daemon is to say of it: these alerts and no other.
struct Scenario {
  const char* name;
  const char* faults;  ///< as `parse_faults`
  /// "ID RAISED CLEARED; …": seconds, or ranges "60..64"; "-": never; "*": whenever, or never.
  const char* alerts;
  int64_t length = 150;               ///< s
  const char* policy = "alert-only";  ///< of [calibration]
  int recordings = -1;                ///< drives recorded; -1: not asked
  const char* calibration =
      nullptr;          ///< at the end: "configured", "true" or "kept"; null: not asked
  bool returns = true;  ///< everything is at its end as it was at its begin
};

/// All of them.
std::span<const Scenario> scenarios();

/// A range of seconds.
struct SecondsRange {
  int64_t from = 0, to = 0;
  bool never = false;     ///< must not be
  bool whenever = false;  ///< may be
};

/// An alert that is expected.
struct ExpectedAlert {
  std::string id;
  SecondsRange raised, cleared;
  bool optional = false;  ///< it need not be; as often as it is
};

/// Parses `Scenario::alerts`, `offset` seconds later. Throws std::invalid_argument.
std::vector<ExpectedAlert> parse_expected(std::string_view text, int64_t offset = 0);

/// An alert that is missing or too much.
struct AlertDifference {
  int64_t second = 0;
  std::string text;
};
inline std::ostream& operator<<(std::ostream& out, const AlertDifference& difference) {
  return out << difference.text;
}

/// Compares observed alerts with the expected ones. Returns what differs. `tolerated`: an id that
/// may be raised and cleared besides; empty: none.
std::vector<AlertDifference> compare_alerts(std::span<const ObservedAlert> observed,
                                            std::span<const ExpectedAlert> expected,
                                            const std::string& tolerated = "");

}  // namespace infuse::study
