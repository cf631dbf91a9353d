#include "daemon/health/latency_histogram.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace infuse::daemon {

size_t LatencyHistogram::bin_of(uint64_t ns) {
  if (ns < kSubBins) return ns;
  const auto octave = static_cast<unsigned>(std::bit_width(ns)) - 1;  // ≥ kSubBits
  const uint64_t sub = (ns >> (octave - kSubBits)) & (kSubBins - 1);
  return (octave - kSubBits + 1) * kSubBins + sub;
}

uint64_t LatencyHistogram::upper_edge(size_t bin) {
  if (bin < kSubBins) return bin;
  const auto octave = static_cast<unsigned>(bin / kSubBins) - 1 + kSubBits;
  const uint64_t width = uint64_t{1} << (octave - kSubBits);
  const uint64_t lower = (uint64_t{1} << octave) + (bin % kSubBins) * width;
  return lower + (width - 1);
}

void LatencyHistogram::add(Duration latency) {
  const auto ns = static_cast<uint64_t>(std::max<int64_t>(latency.count(), 0));
  ++bins_[bin_of(ns)];
  ++count_;
  max_ns_ = std::max(max_ns_, ns);
}

Duration LatencyHistogram::quantile(double q) const {
  if (count_ == 0) return Duration::zero();
  const double rank = std::ceil(std::clamp(q, 0.0, 1.0) * static_cast<double>(count_));
  uint64_t seen = 0;
  for (size_t bin = 0; bin < kBins; ++bin) {
    seen += bins_[bin];
    if (seen > 0 && static_cast<double>(seen) >= rank) {
      return Duration(static_cast<int64_t>(std::min(upper_edge(bin), max_ns_)));
    }
  }
  return Duration(static_cast<int64_t>(max_ns_));
}

LatencyStats LatencyHistogram::stats() const {
  return {count_, quantile(0.5), quantile(0.99), Duration(static_cast<int64_t>(max_ns_))};
}

}  // namespace infuse::daemon
