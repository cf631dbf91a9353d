#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fusion/streetmap/planar_pose.hpp"
#include "fusion/streetmap/segment_map.hpp"

namespace infuse::streetmap {

/// What of the map becomes a label.
enum class Labelling {
  kSegments,  ///< every segment its own, I 3.2.1
  kKinds,     ///< segments of one kind share a label: fewer, so that a dependence is told sooner
};

/// The labels of a piece of the map, dense, so that thousands of look-ups a hypothesis cost a table
/// read each.
class LabelWindow {
 public:
  /// Takes the memory for windows of up to this reach (m), for a map of so many segments.
  void reserve(const SegmentMap& map, double reach, Labelling labelling);

  /// Reads the square of the map within `reach` (m) of a place. Labels that occur are numbered from
  /// 0 in order of their first cell; beyond the 255th they share the last. Allocates nothing once a
  /// window as large was read.
  void read(const SegmentMap& map, double x, double y, double reach, Labelling labelling);

  /// Labels in the window: they are 0 … label_count() − 1.
  int label_count() const { return label_count_; }

  /// The kind that a label stands for: of the segment, or of the first of those that share it.
  SegmentKind kind(int label) const { return kinds_[static_cast<size_t>(label)]; }

  /// Labels of points (m, vehicle frame) for a hypothesis; outside the window they are 0.
  void look_up(const PlanarPose& pose, std::span<const float> x, std::span<const float> y,
               std::span<int32_t> labels) const;

 private:
  double low_x_ = 0, low_y_ = 0;  // m
  double cells_per_metre_ = 1;
  int columns_ = 0, rows_ = 0;
  int label_count_ = 1;
  std::vector<uint8_t> labels_;
  std::vector<uint8_t> by_key_;  // label of a segment or kind, plus one; 0: none yet
  std::vector<uint32_t> used_keys_;
  std::vector<SegmentKind> kinds_;  // by label
};

}  // namespace infuse::streetmap
