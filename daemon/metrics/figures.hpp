#pragma once

#include <span>

namespace infuse::daemon {

/// A figure of HEALTH and what it is called as a metric.
struct Figure {
  const char* path;   ///< JSON pointer from the table it stands in: "/losses/network"
  const char* name;   ///< of the metric
  const char* label;  ///< one more label: cause="network"; empty: none
  const char* type;   ///< "counter" or "gauge"
  const char* help;   ///< with its unit
  double scale = 1;   ///< to that unit
};

/// Of each lidar, of each other device, of odometry, of the street map, of each stage, of each
/// queue, and of the report itself. Figures of one name stand together.
std::span<const Figure> lidar_figures();
std::span<const Figure> stream_figures();
std::span<const Figure> odometry_figures();
std::span<const Figure> streetmap_figures();
std::span<const Figure> stage_figures();
std::span<const Figure> queue_figures();
std::span<const Figure> report_figures();

}  // namespace infuse::daemon
