#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fusion/streetmap/planar_pose.hpp"
#include "fusion/streetmap/segment_map.hpp"

namespace infuse::streetmap {

/// How segments of the map become labels.
enum class Labelling {
  kSegments,  ///< each segment has its own label, I 3.2.1
  kKinds,  ///< segments of one kind share a label: fewer labels, so fewer samples show a dependence
};

/// Labels of a square of the map as a dense table, so that each of the thousands of look-ups per
/// hypothesis is one table read.
class LabelWindow {
 public:
  /// Reserves memory for windows of up to `reach` (m) and for the number of segments of `map`.
  void reserve(const SegmentMap& map, double reach, Labelling labelling);

  /// Reads the square of the map within `reach` (m) of a point. Labels that occur are numbered from
  /// 0 in order of their first cell; labels beyond the 255th share the last number. Does not
  /// allocate once a window of this size was read.
  void read(const SegmentMap& map, double x, double y, double reach, Labelling labelling);

  /// Number of labels in the window; labels are 0 … label_count() − 1.
  int label_count() const { return label_count_; }

  /// Segment kind of a label: of its segment, or of the first of the segments that share it.
  SegmentKind kind(int label) const { return kinds_[static_cast<size_t>(label)]; }

  /// Looks up the labels of points (m, vehicle frame) for a hypothesis; 0 outside the window.
  void look_up(const PlanarPose& pose, std::span<const float> x, std::span<const float> y,
               std::span<int32_t> labels) const;

 private:
  double low_x_ = 0, low_y_ = 0;  // m
  double cells_per_metre_ = 1;
  int columns_ = 0, rows_ = 0;
  int label_count_ = 1;
  std::vector<uint8_t> labels_;
  std::vector<uint32_t> row_ids_;
  std::vector<uint8_t> by_key_;  // label of a segment or kind plus one; 0: none yet
  std::vector<uint32_t> used_keys_;
  std::vector<SegmentKind> kinds_;  // by label
};

}  // namespace infuse::streetmap
