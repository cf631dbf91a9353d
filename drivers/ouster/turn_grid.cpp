#include "drivers/ouster/turn_grid.hpp"

#include <cmath>

#include "drivers/measurement/angles.hpp"

namespace infuse::ouster {

TurnGrid::TurnGrid(const Metadata& metadata, double cut_azimuth)
    : columns_(metadata.columns_per_turn), window_(metadata.window_columns()) {
  const double from_begin = cut_azimuth + metadata.begin_azimuth() / kDegree;
  const auto cut = static_cast<int>(std::lround(from_begin / 360 * columns_));
  first_ = window_ < columns_ ? metadata.window.first : (cut % columns_ + columns_) % columns_;
}

}  // namespace infuse::ouster
