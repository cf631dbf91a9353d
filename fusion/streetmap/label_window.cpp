#include "fusion/streetmap/label_window.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::streetmap {

void LabelWindow::reserve(const SegmentMap& map, double reach, Labelling labelling) {
  const auto edge = static_cast<size_t>(std::ceil(2 * reach / map.frame().cell_size)) + 1;
  labels_.reserve(edge * edge);
  row_ids_.reserve(edge);
  const size_t keys = labelling == Labelling::kKinds ? kSegmentKindCount : map.segment_count();
  by_key_.assign(keys, 0);
  used_keys_.reserve(keys);
  kinds_.reserve(std::min<size_t>(keys, 255));
}

void LabelWindow::read(const SegmentMap& map, double x, double y, double reach,
                       Labelling labelling) {
  const MapFrame& frame = map.frame();
  const auto first = [&](double place, double low) {
    const double cell = std::floor((place - reach - low) / frame.cell_size);
    return static_cast<int>(std::clamp(cell, -1e8, 1e8));
  };
  const int first_column = first(x, frame.min_corner.x()),
            first_row = first(y, frame.min_corner.y());
  columns_ = rows_ = static_cast<int>(std::ceil(2 * reach / frame.cell_size)) + 1;
  low_x_ = frame.min_corner.x() + first_column * frame.cell_size;
  low_y_ = frame.min_corner.y() + first_row * frame.cell_size;
  cells_per_metre_ = 1 / frame.cell_size;
  row_ids_.resize(static_cast<size_t>(columns_));
  labels_.resize(static_cast<size_t>(columns_) * static_cast<size_t>(rows_));

  const size_t keys = labelling == Labelling::kKinds ? kSegmentKindCount : map.segment_count();
  if (by_key_.size() != keys) {
    by_key_.assign(keys, 0);
    used_keys_.clear();
  }
  for (const uint32_t key : used_keys_) by_key_[key] = 0;
  used_keys_.clear();
  label_count_ = 0;
  kinds_.clear();
  uint32_t last_id = UINT32_MAX;
  uint8_t last_label = 0;
  size_t at = 0;
  for (int row = first_row; row < first_row + rows_; ++row) {
    map.read_row(first_column, row, row_ids_);
    for (const uint32_t id : row_ids_) {
      if (id != last_id) {
        const uint32_t key =
            labelling == Labelling::kKinds ? static_cast<uint32_t>(map.segment(id).kind) : id;
        if (by_key_[key] == 0) {
          label_count_ = std::min(label_count_ + 1, 255);
          kinds_.resize(static_cast<size_t>(label_count_), map.segment(id).kind);
          by_key_[key] = static_cast<uint8_t>(label_count_);
          used_keys_.push_back(key);
        }
        last_id = id;
        last_label = static_cast<uint8_t>(by_key_[key] - 1);
      }
      labels_[at++] = last_label;
    }
  }
}

void LabelWindow::look_up(const PlanarPose& pose, std::span<const float> x,
                          std::span<const float> y, std::span<int32_t> labels) const {
  // In cells of the window; single precision resolves a millimetre over several kilometres.
  const auto scale = static_cast<float>(cells_per_metre_);
  const auto c = static_cast<float>(std::cos(pose.yaw)) * scale;
  const auto s = static_cast<float>(std::sin(pose.yaw)) * scale;
  const auto x0 = static_cast<float>((pose.x - low_x_) * cells_per_metre_);
  const auto y0 = static_cast<float>((pose.y - low_y_) * cells_per_metre_);
  const auto columns = static_cast<float>(columns_), rows = static_cast<float>(rows_);
  for (size_t i = 0; i < x.size(); ++i) {
    const float column = x0 + c * x[i] - s * y[i];
    const float row = y0 + s * x[i] + c * y[i];
    const bool inside = column >= 0 && row >= 0 && column < columns && row < rows;
    labels[i] = inside ? labels_[static_cast<size_t>(row) * static_cast<size_t>(columns_) +
                                 static_cast<size_t>(column)]
                       : 0;
  }
}

}  // namespace infuse::streetmap
