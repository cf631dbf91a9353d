#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "drivers/measurement/median.hpp"
#include "drivers/recording/sweep_files.hpp"

namespace infuse::recording {
namespace {

constexpr double kBinsPerDegree = 100;  // histogram of elevations
constexpr size_t kElevationBins = 18'000;
constexpr size_t kMinReturns = 400;  // of a sweep whose rings can be told apart
constexpr std::array<int, 6> kSmoothing{1, 2, 4, 8, 16, 32};  // bins each side, tried in order
constexpr double kValleyShare = 0.25;    // of the peaks beside it: as low is between two rings
constexpr double kMinRingShare = 0.01;   // of the median ring; fewer returns are stray ones
constexpr double kMaxStrayShare = 0.02;  // of all returns
constexpr double kMinCoreShare = 0.9;    // of all returns, in the middle half of their rings
constexpr double kDegreesPerRadian = 57.29577951308232;

using Histogram = std::vector<double>;

/// A ring: elevations from `begin` to the next ring's begin, most of them near `peak`. Bins.
struct ElevationRing {
  size_t begin = 0, peak = 0;
  double returns = 0;
};

size_t elevation_bin(const Sweep& sweep, size_t i) {
  const double sine = static_cast<double>(sweep.z[i]) / static_cast<double>(sweep.range[i]);
  const double elevation = std::asin(std::clamp(sine, -1.0, 1.0)) * kDegreesPerRadian;
  const double bin = (elevation + 90) * kBinsPerDegree;
  return std::min(static_cast<size_t>(std::max(bin, 0.0)), kElevationBins - 1);
}

/// Means over `radius` bins on each side, twice.
Histogram smoothed(Histogram values, int radius) {
  const auto r = static_cast<size_t>(radius);
  for (int pass = 0; pass < 2; ++pass) {
    Histogram sum(values.size() + 1, 0.0);
    for (size_t b = 0; b < values.size(); ++b) sum[b + 1] = sum[b] + values[b];
    for (size_t b = 0; b < values.size(); ++b) {
      const size_t first = b < r ? 0 : b - r;
      const size_t last = std::min(b + r + 1, values.size());
      values[b] = (sum[last] - sum[first]) / static_cast<double>(2 * r + 1);
    }
  }
  return values;
}

/// Peaks of the density that are separated by valleys, from below. A valley's middle is the border.
std::vector<ElevationRing> find_peaks(const Histogram& density) {
  std::vector<ElevationRing> rings;
  bool rising = false;
  size_t low_begin = 0, low_end = 0, peak = 0;
  for (size_t b = 0; b < density.size(); ++b) {
    if (!rising) {
      if (density[b] < density[low_begin]) low_begin = b;
      if (density[b] <= density[low_begin]) low_end = b;
      if (density[b] * kValleyShare <= density[low_begin]) continue;
      rings.push_back({.begin = (low_begin + low_end) / 2, .peak = b});
      rising = true;
      peak = b;
    } else {
      if (density[b] > density[peak]) peak = b;
      rings.back().peak = peak;
      if (density[b] >= kValleyShare * density[peak]) continue;
      rising = false;
      low_begin = low_end = b;
    }
  }
  if (!rings.empty()) rings.front().begin = 0;
  return rings;
}

/// Counts the rings' returns and joins groups of stray ones to the ring below. Returns the number
/// of stray returns.
double join_strays(const Histogram& histogram, std::vector<ElevationRing>& rings) {
  std::vector<double> counts;
  for (size_t k = 0; k < rings.size(); ++k) {
    const size_t end = k + 1 < rings.size() ? rings[k + 1].begin : histogram.size();
    rings[k].returns =
        std::accumulate(histogram.begin() + static_cast<std::ptrdiff_t>(rings[k].begin),
                        histogram.begin() + static_cast<std::ptrdiff_t>(end), 0.0);
    counts.push_back(rings[k].returns);
  }
  if (counts.empty()) return 0;
  const double min_returns = kMinRingShare * median(counts);
  double strays = 0;
  std::erase_if(rings, [&](const ElevationRing& ring) {
    const bool stray = ring.returns < min_returns;
    strays += stray ? ring.returns : 0;
    return stray;
  });
  if (!rings.empty()) rings.front().begin = 0;
  return strays;
}

/// Share of the returns within the middle half of their rings.
double core_share(const Histogram& histogram, const std::vector<ElevationRing>& rings) {
  double core = 0, all = 0;
  for (size_t k = 0; k < rings.size(); ++k) {
    const size_t peak = rings[k].peak;
    // The outermost rings reach as far out as in.
    const size_t above = k + 1 < rings.size() ? rings[k + 1].begin - peak : peak - rings[k].begin;
    const size_t below = k > 0 ? peak - rings[k].begin : above;
    const size_t end = k + 1 < rings.size() ? rings[k + 1].begin : histogram.size();
    for (size_t b = rings[k].begin; b < end; ++b) {
      all += histogram[b];
      if (b + below / 2 >= peak && b <= peak + above / 2) core += histogram[b];
    }
  }
  return all > 0 ? core / all : 0;
}

/// Rings from below, or nothing.
std::vector<ElevationRing> cluster_elevations(const Histogram& histogram, double returns) {
  for (const int radius : kSmoothing) {
    std::vector<ElevationRing> rings = find_peaks(smoothed(histogram, radius));
    if (rings.size() > 4 * kMaxRings) continue;
    const double strays = join_strays(histogram, rings);
    if (rings.size() < 2 || rings.size() > kMaxRings || strays > kMaxStrayShare * returns) continue;
    if (core_share(histogram, rings) >= kMinCoreShare) return rings;
  }
  return {};
}

template <class T>
void reorder(FieldVector<T>& values, const std::vector<uint32_t>& order) {
  FieldVector<T> sorted(values.size());
  for (size_t k = 0; k < order.size(); ++k) sorted[k] = values[order[k]];
  values.swap(sorted);
}

}  // namespace

bool restore_rings(Sweep& sweep) {
  const size_t n = sweep.size();
  if (n < kMinReturns) return false;
  const bool at_origin =
      std::any_of(sweep.range.begin(), sweep.range.end(), [](float range) { return !(range > 0); });
  if (at_origin) return false;
  Histogram histogram(kElevationBins, 0.0);
  std::vector<uint16_t> bins(n);
  for (size_t i = 0; i < n; ++i) {
    bins[i] = static_cast<uint16_t>(elevation_bin(sweep, i));
    ++histogram[bins[i]];
  }
  const std::vector<ElevationRing> rings = cluster_elevations(histogram, static_cast<double>(n));
  if (rings.empty()) return false;

  std::vector<uint16_t> from_top(kElevationBins);
  for (size_t k = 0; k < rings.size(); ++k) {
    std::fill(from_top.begin() + static_cast<std::ptrdiff_t>(rings[k].begin), from_top.end(),
              static_cast<uint16_t>(rings.size() - 1 - k));
  }
  std::vector<size_t> starts(rings.size() + 1, 0);
  std::vector<float> azimuth(n);
  std::vector<uint32_t> order(n);
  for (size_t i = 0; i < n; ++i) {
    ++starts[from_top[bins[i]] + size_t{1}];
    azimuth[i] = std::atan2(sweep.y[i], sweep.x[i]);
    if (azimuth[i] < 0) azimuth[i] += 2 * std::numbers::pi_v<float>;
    order[i] = static_cast<uint32_t>(i);
  }
  std::partial_sum(starts.begin(), starts.end(), starts.begin());
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    if (from_top[bins[a]] != from_top[bins[b]]) return from_top[bins[a]] < from_top[bins[b]];
    return azimuth[a] != azimuth[b] ? azimuth[a] < azimuth[b] : a < b;
  });
  for (FieldVector<float>* values :
       {&sweep.x, &sweep.y, &sweep.z, &sweep.range, &sweep.reflectivity}) {
    reorder(*values, order);
  }
  reorder(sweep.time_offset_ns, order);
  reorder(sweep.return_kind, order);
  return assign_rings(sweep, starts);
}

}  // namespace infuse::recording
