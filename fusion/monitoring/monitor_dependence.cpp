#include "fusion/monitoring/monitor_dependence.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace infuse::monitoring {
namespace {

constexpr int kBins = ComparedReturns::kBins;

using Histogram = std::array<float, static_cast<size_t>(kBins) * kBins>;

float look_up(const std::vector<float>& plane, size_t width, size_t at, float a, float b) {
  const float* top = plane.data() + at;
  const float* low = top + width;
  const float upper = top[0] + a * (top[1] - top[0]);
  const float lower = low[0] + a * (low[1] - low[0]);
  return upper + b * (lower - upper);
}

/// Spreads one sample over the two bins between whose centres its value lies.
void add_sample(Histogram& table, uint8_t row, float value) {
  const float at = std::clamp(value * kBins - 0.5F, 0.0F, static_cast<float>(kBins - 1) - 1e-3F);
  const int bin = static_cast<int>(at);
  const float part = at - static_cast<float>(bin);
  float* cell = table.data() + row * kBins + bin;
  cell[0] += 1 - part;
  cell[1] += part;
}

/// Sum of a table's weights, and their plug-in mutual information, nats.
struct MutualInformation {
  double weight = 0;
  double nats = 0;
};

MutualInformation mutual_information(const Histogram& table) {
  std::array<double, kBins> rows{}, columns{};
  double sum = 0;
  for (size_t r = 0; r < kBins; ++r) {
    for (size_t c = 0; c < kBins; ++c) {
      const double weight = table[r * kBins + c];
      rows[r] += weight;
      columns[c] += weight;
      sum += weight;
    }
  }
  if (!(sum > 0)) return {};
  const auto term = [](double weight) { return weight > 0 ? weight * std::log(weight) : 0.0; };
  double total = term(sum);
  for (const float weight : table) total += term(double{weight});
  for (size_t k = 0; k < kBins; ++k) total -= term(rows[k]) + term(columns[k]);
  return {sum, total / sum};
}

}  // namespace

double MonitorDependence::evaluate(const Eigen::Isometry3d& T_camera_lidar,
                                   const ComparedPlanes& planes, const ComparedReturns& returns,
                                   const geometry::CameraModel& camera, Outside outside) {
  const features::Plane& grey = planes.grey;
  if (grey.width < 2 || grey.height < 2) return 0;
  for (auto* scratch : {&u_, &v_, &depth_}) scratch->resize(returns.size());
  geometry::project_points(camera, T_camera_lidar, returns.points(), {u_, v_, depth_});
  const auto width = static_cast<size_t>(grey.width);
  const auto right = static_cast<float>(grey.width - 1) - 1e-3F;
  const auto bottom = static_cast<float>(grey.height - 1) - 1e-3F;
  const float thin = 1.0F / static_cast<float>(grey.step);
  const float scale = thin / static_cast<float>(planes.step);
  // A mean belongs to the middle of its pixels, a thinned sample to where it is.
  const float shift = 0.5F * scale - 0.5F * thin;
  Histogram reflectivity{}, edge{};
  size_t beside = 0, edges_beside = 0;  // returns that say nothing
  for (size_t i = 0; i < returns.size(); ++i) {
    if (!(u_[i] == u_[i])) continue;
    const float inner_u = u_[i] * scale + shift, inner_v = v_[i] * scale + shift;
    const float u = std::clamp(inner_u, 0.0F, right);
    const float v = std::clamp(inner_v, 0.0F, bottom);
    const bool has_edge = returns.edge_bin[i] != ComparedReturns::kNotCompared;
    if (outside == Outside::kNothing && (u != inner_u || v != inner_v)) {
      ++beside;
      edges_beside += has_edge ? 1 : 0;
      continue;
    }
    const auto column = static_cast<size_t>(u);
    const auto row = static_cast<size_t>(v);
    const float a = u - static_cast<float>(column);
    const float b = v - static_cast<float>(row);
    const size_t at = row * width + column;
    add_sample(reflectivity, returns.reflectivity_bin[i], look_up(grey.values, width, at, a, b));
    if (!has_edge) continue;
    add_sample(edge, returns.edge_bin[i], look_up(planes.edge.values, width, at, a, b));
  }
  const MutualInformation of_reflectivity = mutual_information(reflectivity);
  const MutualInformation of_edges = mutual_information(edge);
  const double all = weights_.reflectivity > 0
                         ? of_reflectivity.weight + static_cast<double>(beside)
                         : of_edges.weight + static_cast<double>(edges_beside);
  if (!(all > 0)) return 0;
  return (weights_.reflectivity * of_reflectivity.weight * of_reflectivity.nats +
          weights_.edges * of_edges.weight * of_edges.nats) /
         all;
}

}  // namespace infuse::monitoring
