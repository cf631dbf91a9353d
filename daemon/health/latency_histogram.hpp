#pragma once

#include <array>
#include <cstdint>

#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// Statistics of a latency histogram, in host time.
struct LatencyStats {
  uint64_t count = 0;
  Duration p50{0};
  Duration p99{0};
  Duration max{0};
};

/// Histogram of one stage's latencies: exact below 16 ns, above that with bins of 1/16 octave, so
/// that a quantile is at most 6.25 % too large. Does not allocate.
class LatencyHistogram {
 public:
  /// Adds a latency; a negative one counts as 0.
  void add(Duration latency);

  /// Returns the smallest bin edge that at least the fraction `q` (0 … 1) of the latencies do not
  /// exceed, at most the maximum latency; 0 if nothing was added.
  Duration quantile(double q) const;

  LatencyStats stats() const;

 private:
  static constexpr unsigned kSubBits = 4;
  static constexpr unsigned kSubBins = 1U << kSubBits;
  static constexpr size_t kBins = size_t{64 - kSubBits + 1} * kSubBins;

  static size_t bin_of(uint64_t ns);
  static uint64_t upper_edge(size_t bin);

  std::array<uint64_t, kBins> bins_{};
  uint64_t count_ = 0;
  uint64_t max_ns_ = 0;
};

}  // namespace infuse::daemon
