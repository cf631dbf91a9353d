#include "daemon/pipeline/sweep_summary.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace infuse::daemon {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Sums in eight lanes, added in a fixed order: fast, and the same on every processor.
double sum_of(const FieldVector<float>& values) {
  constexpr size_t kLanes = 8;
  std::array<double, kLanes> sums{};
  const size_t whole = values.size() / kLanes * kLanes;
  for (size_t i = 0; i < whole; i += kLanes) {
    for (size_t lane = 0; lane < kLanes; ++lane) {
      sums[lane] += static_cast<double>(values[i + lane]);
    }
  }
  double sum = 0;
  for (const double lane : sums) sum += lane;
  for (size_t i = whole; i < values.size(); ++i) sum += static_cast<double>(values[i]);
  return sum;
}

double mean_of(const FieldVector<float>& values) {
  return values.empty() ? kNan : sum_of(values) / static_cast<double>(values.size());
}

double max_of(const FieldVector<float>& values) {
  float max = -std::numeric_limits<float>::infinity();
  for (const float value : values) max = value > max ? value : max;
  return values.empty() ? kNan : static_cast<double>(max);
}

/// Returns the width of a gap, 0 … 2π rad.
double width_of(const AzimuthGap& gap) {
  constexpr double kTurn = 2 * std::numbers::pi;
  return std::min(std::abs(gap.to - gap.from), kTurn);
}

}  // namespace

SweepReport summarise(const Sweep& sweep, std::string_view device) {
  SweepReport report;
  report.device = device;
  report.stamp = sweep.stamp;
  report.span = sweep.span;
  report.sequence = sweep.sequence;
  report.returns = sweep.size();
  report.columns = sweep.columns;
  report.rings = sweep.rings;
  report.lost_packets = sweep.lost_packets;
  report.gaps = static_cast<uint32_t>(sweep.gaps.size());
  for (const AzimuthGap& gap : sweep.gaps) report.gap_angle += width_of(gap);
  report.mean_range = mean_of(sweep.range);
  report.max_range = max_of(sweep.range);
  report.mean_reflectivity = mean_of(sweep.reflectivity);
  report.has_times = sweep.has_times;
  report.clock_trusted = sweep.clock.trusted;
  return report;
}

}  // namespace infuse::daemon
