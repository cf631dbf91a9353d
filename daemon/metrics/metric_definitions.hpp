#pragma once

#include <span>

namespace infuse::daemon {

/// A figure of HEALTH and what it is called as a metric.
struct MetricDefinition {
  const char* path;   ///< JSON pointer from the table it stands in: "/losses/network"
  const char* name;   ///< of the metric
  const char* label;  ///< one more label: cause="network"; empty: none
  const char* type;   ///< "counter" or "gauge"
  const char* help;   ///< with its unit
  double scale = 1;   ///< to that unit
};

/// Of each lidar, of each other device, of odometry, of the street map, of each stage, of each
/// queue, and of the report itself. Figures of one name stand together.
std::span<const MetricDefinition> lidar_metrics();
std::span<const MetricDefinition> stream_metrics();
std::span<const MetricDefinition> odometry_metrics();
std::span<const MetricDefinition> streetmap_metrics();
std::span<const MetricDefinition> stage_metrics();
std::span<const MetricDefinition> queue_metrics();
std::span<const MetricDefinition> report_metrics();

}  // namespace infuse::daemon
