#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "drivers/measurement/rig.hpp"
#include "fusion/target/find_boards.hpp"

namespace infuse::target {

/// Where in the image there are corners.
struct ImageCoverage {
  static constexpr int kColumns = 16, kRows = 12;  // of `cells`; by definition
  std::array<int, kColumns * kRows> cells{};       ///< number of corners, row by row from the top
  double share = 0;                                ///< of the cells that have corners
  /// px from the principal point: the farthest that corners of at least three views reach.
  double radius = 0;
  double corner_radius = 0;  ///< px from the principal point to the farthest corner of the image
  std::string
      empty_parts;  ///< ninths of the image without corners: "top left, bottom"; may be empty
};

/// Coverage of a camera's image by the corners of the used views.
ImageCoverage measure_coverage(const CameraIntrinsics& camera, std::span<const Corners> views,
                               const std::vector<bool>& used);

}  // namespace infuse::target
