#include "fusion/features/occlusion_buffer.hpp"

#include <algorithm>

namespace infuse::features {

std::optional<std::string> OcclusionOptions::invalid() const {
  if (!(cell_size >= 1)) return "cell_size must be at least 1";
  if (!(ratio >= 1)) return "ratio must be at least 1";
  if (!(step >= 0)) return "step must not be negative";
  return std::nullopt;
}

OcclusionBuffer::OcclusionBuffer(const OcclusionOptions& options)
    : cells_per_pixel_(static_cast<float>(1 / options.cell_size)),
      ratio_(static_cast<float>(options.ratio)),
      step_(static_cast<float>(options.step)),
      with_neighbours_(options.with_neighbours) {}

void OcclusionBuffer::reset(int width, int height) {
  columns_ = static_cast<int>(static_cast<float>(width) * cells_per_pixel_) + 3;
  rows_ = static_cast<int>(static_cast<float>(height) * cells_per_pixel_) + 3;
  nearest_.assign(static_cast<size_t>(columns_) * static_cast<size_t>(rows_), kEmpty);
}

float OcclusionBuffer::nearest(float u, float v) const {
  const size_t here = cell(u, v);
  if (!with_neighbours_) return nearest_[here];
  const auto columns = static_cast<size_t>(columns_);
  float nearest = kEmpty;
  for (size_t row = here - columns; row <= here + columns; row += columns) {
    const float* cells = &nearest_[row];
    nearest = std::min({nearest, cells[-1], cells[0], cells[1]});
  }
  return nearest;
}

}  // namespace infuse::features
