#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "drivers/measurement/fast_atan2.hpp"
#include "drivers/recording/sweep_files.hpp"

namespace infuse::recording {
namespace {

constexpr size_t kHistogramBins = 4096;   // histogram of azimuth steps
constexpr double kBinsPerTurn = 1 << 18;  // the largest step in the histogram is 1/64 turn
constexpr double kTwoPi = 2 * std::numbers::pi;

// First point of each ring: ring k consists of the points starts[k] … starts[k + 1] − 1.
struct RingStarts {
  std::array<size_t, kMaxRings + 1> starts{};
  size_t count = 0;  // 0 if there are too many
};

// True if the azimuth (0 … 2π) decreases by more than π from point i − 1 to point i, that is, the
// sweep crosses the positive x axis from right to left. Exact, without trigonometry.
bool azimuth_wraps(const Sweep& sweep, size_t i) {
  const float x0 = sweep.x[i - 1], y0 = sweep.y[i - 1], x1 = sweep.x[i], y1 = sweep.y[i];
  return y0 < 0 && y1 >= 0 &&
         static_cast<double>(x0) * static_cast<double>(y1) >
             static_cast<double>(y0) * static_cast<double>(x1);
}

RingStarts find_rings(const Sweep& sweep) {
  RingStarts rings;
  rings.count = 1;
  for (size_t i = 1; i < sweep.size(); ++i) {
    if (!azimuth_wraps(sweep, i)) continue;
    if (rings.count == kMaxRings) return {};
    rings.starts[rings.count++] = i;
  }
  rings.starts[rings.count] = sweep.size();
  return rings;
}

bool elevations_decrease(const Sweep& sweep, const RingStarts& rings) {
  size_t rising = 0;
  double previous = 0;
  for (size_t k = 0; k < rings.count; ++k) {
    double sum = 0;  // of sines of the elevation
    for (size_t i = rings.starts[k]; i < rings.starts[k + 1]; ++i) {
      if (sweep.range[i] > 0) {
        sum += static_cast<double>(sweep.z[i]) / static_cast<double>(sweep.range[i]);
      }
    }
    const double mean = sum / static_cast<double>(rings.starts[k + 1] - rings.starts[k]);
    if (k > 0 && mean > previous) ++rising;
    previous = mean;
  }
  return rising * 10 <= rings.count;
}

double compute_azimuth(const Sweep& sweep, size_t i) {
  const double angle = fast_atan2(static_cast<double>(sweep.y[i]), static_cast<double>(sweep.x[i]));
  return angle < 0 ? angle + kTwoPi : angle;
}

// Azimuth step from a point to the next, turns; a whole turn if it is larger than 0.1 rad. The
// series of the arc tangent is then exact to 2e-9 turns.
double compute_step(const Sweep& sweep, size_t i) {
  const double x0 = static_cast<double>(sweep.x[i]);
  const double y0 = static_cast<double>(sweep.y[i]);
  const double x1 = static_cast<double>(sweep.x[i + 1]);
  const double y1 = static_cast<double>(sweep.y[i + 1]);
  const double sine = x0 * y1 - y0 * x1;
  const double cosine = x0 * x1 + y0 * y1;
  if (!(std::abs(sine) < 0.1 * cosine)) return 1;
  const double t = sine / cosine;
  return t * (1 - t * t * (1.0 / 3 - t * t / 5)) / kTwoPi;
}

// Calls `use` with each azimuth step to the next point of the same ring, in turns.
template <class Use>
void for_each_step(const Sweep& sweep, const RingStarts& rings, const Use& use) {
  for (size_t k = 0; k < rings.count; ++k) {
    for (size_t i = rings.starts[k]; i + 1 < rings.starts[k + 1]; ++i) use(compute_step(sweep, i));
  }
}

// Returns the number of steps per turn: the mean of the steps near the median, which is found with
// a histogram. 0 if unknown.
uint32_t count_columns(const Sweep& sweep, const RingStarts& rings) {
  std::array<uint32_t, kHistogramBins> histogram{};
  uint64_t steps = 0;
  for_each_step(sweep, rings, [&](double step) {
    const double bin = step * kBinsPerTurn;
    if (!(bin >= 1 && bin < static_cast<double>(kHistogramBins))) return;
    ++histogram[static_cast<size_t>(bin)];
    ++steps;
  });
  if (steps == 0) return 0;
  size_t bin = 0;
  for (uint64_t below = histogram[0]; below * 2 < steps; below += histogram[++bin]) continue;
  const double median = (static_cast<double>(bin) + 0.5) / kBinsPerTurn;
  double sum = 0;
  uint64_t near = 0;
  for_each_step(sweep, rings, [&](double step) {
    if (step < 0.6 * median || step > 1.4 * median) return;
    sum += step;
    ++near;
  });
  if (near == 0) return 0;
  const double columns = std::round(static_cast<double>(near) / sum);
  return columns <= 65535 ? static_cast<uint32_t>(columns) : 0;
}

void clear_rings(Sweep& sweep) {
  std::fill(sweep.ring.begin(), sweep.ring.end(), uint16_t{0});
  std::fill(sweep.column.begin(), sweep.column.end(), uint16_t{0});
  sweep.rings = 0;
  sweep.columns = 0;
}

// Fills `ring`, `column`, `rings`, `columns`. Returns false and changes nothing if the column width
// cannot be determined.
bool assign_rings_and_columns(Sweep& sweep, const RingStarts& rings) {
  const uint32_t columns = count_columns(sweep, rings);
  if (columns == 0) return false;

  sweep.rings = static_cast<uint16_t>(rings.count);
  sweep.columns = columns;
  for (size_t k = 0; k < rings.count; ++k) {
    const auto ring = static_cast<uint16_t>(rings.count - 1 - k);
    for (size_t i = rings.starts[k]; i < rings.starts[k + 1]; ++i) {
      const double step = compute_azimuth(sweep, i) / kTwoPi * columns;
      sweep.ring[i] = ring;
      sweep.column[i] = static_cast<uint16_t>(std::min(static_cast<uint32_t>(step), columns - 1));
    }
  }
  return true;
}

}  // namespace

bool infer_rings(Sweep& sweep) {
  clear_rings(sweep);
  if (sweep.size() == 0) return false;
  const RingStarts rings = find_rings(sweep);
  return rings.count >= 2 && elevations_decrease(sweep, rings) &&
         assign_rings_and_columns(sweep, rings);
}

bool assign_rings(Sweep& sweep, std::span<const size_t> starts) {
  clear_rings(sweep);
  if (starts.size() < 2 || starts.size() > kMaxRings + 1) return false;
  RingStarts rings;
  std::copy(starts.begin(), starts.end(), rings.starts.begin());
  rings.count = starts.size() - 1;
  return assign_rings_and_columns(sweep, rings);
}

}  // namespace infuse::recording
