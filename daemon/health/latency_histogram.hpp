#pragma once

#include <array>
#include <cstdint>

#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// What a histogram of latencies says, in host time.
struct LatencyStats {
  uint64_t count = 0;
  Duration p50{0};
  Duration p99{0};
  Duration max{0};
};

/// Latencies of one stage in a fixed number of bins: exact below 16 ns, above that bins of 1/16 of
/// their octave, so that a quantile is at most 6.25 % too large. Allocates nothing.
class LatencyHistogram {
 public:
  /// A negative latency counts as 0.
  void add(Duration latency);

  /// The smallest bin edge that at least the fraction `q` (0 … 1) of all latencies do not exceed,
  /// never more than the largest latency; 0 where nothing was added.
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
