#include "fusion/dependence/joint_histogram.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "fusion/dependence/prepared_histogram.hpp"

namespace infuse::dependence {
namespace {

std::optional<std::string> invalid_axis(const Axis& axis, const std::string& name, int min_bins) {
  if (axis.bins < min_bins || axis.bins > kMaxBins) {
    return name + ".bins is " + std::to_string(axis.bins) + ", not in " + std::to_string(min_bins) +
           " ... " + std::to_string(kMaxBins);
  }
  const double span = axis.high - axis.low;
  if (!(span > 1e-30) || !std::isfinite(span) || std::abs(axis.low) > 1e30 || span > 1e30) {
    return name + ".low ... high is not a range within 1e30";
  }
  return {};
}

/// One marginal bin: `count` values, `stride` apart.
struct Line {
  size_t first, stride, count;
};

double sum_line(std::span<const double> mass, const Line& line) {
  double sum = 0;
  for (size_t k = 0; k < line.count; ++k) sum += mass[line.first + k * line.stride];
  return sum;
}

/// Bandwidth P(3.16) of one side, in bins; `line_of` gives its marginal bins.
template <class LineOf>
double silverman_bandwidth(const JointHistogram& histogram, int bins, LineOf line_of) {
  double mean = 0, square = 0;
  for (int i = 0; i < bins; ++i) {
    const double p = sum_line(histogram.mass, line_of(i)) / histogram.total;
    mean += p * i;
    square += p * i * i;
  }
  return 1.06 * std::pow(histogram.samples, -0.2) * std::sqrt(std::max(0.0, square - mean * mean));
}

/// Convolves each line with a Gaussian of `bandwidth` bins; the kernel is renormalised to the part
/// inside the line.
template <class LineOf>
void smooth_lines(std::vector<double>& mass, int lines, LineOf line_of, double bandwidth,
                  std::vector<double>& scratch) {
  if (!(bandwidth > 1e-6)) return;
  const size_t count = line_of(0).count;
  const auto radius = std::min(static_cast<size_t>(std::ceil(5 * bandwidth)), count - 1);
  scratch.assign(radius + 1 + 2 * count, 0.0);
  const std::span<double> kernel(scratch.data(), radius + 1);
  const std::span<double> norm(scratch.data() + radius + 1, count);
  const std::span<double> smoothed(scratch.data() + radius + 1 + count, count);
  for (size_t d = 0; d <= radius; ++d) {
    const double u = static_cast<double>(d) / bandwidth;
    kernel[d] = std::exp(-0.5 * u * u);
  }
  const auto for_neighbours = [&](size_t from, auto&& visit) {
    const size_t last = std::min(from + radius, count - 1);
    for (size_t to = from - std::min(from, radius); to <= last; ++to) {
      visit(to, kernel[to > from ? to - from : from - to]);
    }
  };
  for (size_t i = 0; i < count; ++i) {
    for_neighbours(i, [&](size_t, double weight) { norm[i] += weight; });
  }
  for (int index = 0; index < lines; ++index) {
    const Line line = line_of(index);
    std::fill(smoothed.begin(), smoothed.end(), 0.0);
    for (size_t from = 0; from < count; ++from) {
      const double source = mass[line.first + from * line.stride] / norm[from];
      if (source == 0) continue;
      for_neighbours(from, [&](size_t to, double weight) { smoothed[to] += weight * source; });
    }
    for (size_t k = 0; k < count; ++k) mass[line.first + k * line.stride] = smoothed[k];
  }
}

}  // namespace

std::optional<std::string> JointHistogramOptions::invalid() const {
  const int min_bins = window == Window::kBSpline ? 4 : 1;
  if (auto wrong = invalid_axis(x, "x", min_bins)) return wrong;
  return invalid_axis(y, "y", min_bins);
}

void update_total(JointHistogram& histogram) {
  const auto bins_x = static_cast<size_t>(histogram.bins_x);
  const auto bins_y = static_cast<size_t>(histogram.bins_y);
  histogram.total = std::accumulate(histogram.mass.begin(), histogram.mass.end(), 0.0);
  histogram.reason = "";
  if (!(histogram.total > 0)) {
    histogram.reason = "no valid samples";
    return;
  }
  const double all = histogram.total * (1 - 1e-12);
  for (size_t i = 0; i < bins_x; ++i) {
    if (sum_line(histogram.mass, {i * bins_y, 1, bins_y}) >= all) {
      histogram.reason = kConstantSide;
    }
  }
  for (size_t i = 0; i < bins_y; ++i) {
    if (sum_line(histogram.mass, {i, bins_y, bins_x}) >= all) {
      histogram.reason = kConstantSide;
    }
  }
  if (histogram.usable() && histogram.samples < std::max(histogram.bins_x, histogram.bins_y)) {
    histogram.reason = kFewerSamplesThanBins;
  }
}

JointHistogram joint_histogram(std::span<const float> x, std::span<const float> y,
                               const JointHistogramOptions& options,
                               std::span<const float> weights) {
  return PreparedHistogram(x, options, weights).histogram(y);
}

void smooth_gaussian(JointHistogram& histogram, std::vector<double>& scratch) {
  if (!(histogram.total > 0)) return;
  const auto bins_x = static_cast<size_t>(histogram.bins_x);
  const auto bins_y = static_cast<size_t>(histogram.bins_y);
  const auto row = [&](int i) { return Line{static_cast<size_t>(i) * bins_y, 1, bins_y}; };
  const auto column = [&](int i) { return Line{static_cast<size_t>(i), bins_y, bins_x}; };
  const double bandwidth_x = silverman_bandwidth(histogram, histogram.bins_x, row);
  const double bandwidth_y = silverman_bandwidth(histogram, histogram.bins_y, column);
  smooth_lines(histogram.mass, histogram.bins_x, row, bandwidth_y, scratch);
  smooth_lines(histogram.mass, histogram.bins_y, column, bandwidth_x, scratch);
}

}  // namespace infuse::dependence
