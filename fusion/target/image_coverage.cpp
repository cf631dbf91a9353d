#include "fusion/target/image_coverage.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace infuse::target {
namespace {

constexpr std::array kParts = {"top left", "top",         "top right", "left",        "middle",
                               "right",    "bottom left", "bottom",    "bottom right"};

/// Cell of a coordinate among `cells` along a side of `size` pixels.
int cell_at(double coordinate, int size, int cells) {
  return std::clamp(static_cast<int>((coordinate + 0.5) / size * cells), 0, cells - 1);
}

}  // namespace

ImageCoverage measure_coverage(const CameraIntrinsics& camera, std::span<const Corners> views,
                               const std::vector<bool>& used) {
  ImageCoverage out;
  const Eigen::Vector2d centre(camera.cx, camera.cy);
  std::array<int, kParts.size()> parts{};
  std::vector<double> reach;  // of each view
  for (size_t v = 0; v < views.size(); ++v) {
    if (!used[v]) continue;
    reach.push_back(0);
    for (const Eigen::Vector2d& at : views[v]) {
      const int column = cell_at(at.x(), camera.width, ImageCoverage::kColumns);
      const int row = cell_at(at.y(), camera.height, ImageCoverage::kRows);
      ++out.cells[static_cast<size_t>(row * ImageCoverage::kColumns + column)];
      ++parts[static_cast<size_t>(3 * cell_at(at.y(), camera.height, 3) +
                                  cell_at(at.x(), camera.width, 3))];
      reach.back() = std::max(reach.back(), (at - centre).norm());
    }
  }
  const auto filled = std::ranges::count_if(out.cells, [](int count) { return count > 0; });
  out.share = static_cast<double>(filled) / static_cast<double>(out.cells.size());
  std::ranges::sort(reach, std::greater<>());
  if (reach.size() >= 3) out.radius = reach[2];
  out.corner_radius = std::hypot(std::max(centre.x(), camera.width - 1 - centre.x()),
                                 std::max(centre.y(), camera.height - 1 - centre.y()));
  for (size_t i = 0; i < parts.size(); ++i) {
    if (parts[i] == 0)
      out.empty_parts += (out.empty_parts.empty() ? "" : ", ") + std::string(kParts[i]);
  }
  return out;
}

}  // namespace infuse::target
