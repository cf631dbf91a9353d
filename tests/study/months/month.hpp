#pragma once

#include <iosfwd>

#include "tests/study/months/scenarios.hpp"

namespace infuse::study {

/// Settings of a long simulation.
struct MonthOptions {
  double days = 30;
  uint64_t seed = 1;
  double mean_gap_s = 3600;  ///< between scenarios, beside `kMinGap`
};

/// What a long simulation showed.
struct MonthResult {
  size_t scenarios = 0;                  ///< drawn
  size_t raised = 0;                     ///< alerts
  size_t suspected = 0;                  ///< of these, drifts that were only suspected
  std::vector<std::string> differences;  ///< alerts that are missing or too much
  std::vector<std::string> problems;
  std::vector<uint64_t> resident;  ///< bytes of this process at the end of each day
  uint64_t max_recorded = 0;       ///< bytes of all recordings together, at most
  uint64_t recordings = 0;
  uint64_t history = 0;  ///< bytes of the history at the end
  uint64_t state = 0;    ///< bytes of the state at the end, without recordings

  /// Prints it as lines; returns whether all is as it should be.
  bool print(std::ostream& out) const;
};

/// Drives for days, with scenarios of the table drawn by the seed one after the other.
MonthResult simulate_month(const MonthOptions& options);

}  // namespace infuse::study
