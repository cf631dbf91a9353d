#pragma once

#include <algorithm>
#include <cstdint>

#include "drivers/ouster/metadata.hpp"

namespace infuse::ouster {

/// Numbers a sensor's columns through turns that begin where sweeps are cut. A column's place is
/// its turn times the columns of a turn, plus its index, which is counted from the cut.
class TurnGrid {
 public:
  /// A sensor that sends a part of the turn only is cut where that part begins; another one at
  /// `cut_azimuth`, ° clockwise from the front; the turn of most sensors begins behind.
  TurnGrid(const Metadata& metadata, double cut_azimuth);

  /// Columns of a turn.
  int columns_per_turn() const { return columns_; }

  /// Columns of a sweep: those of the window.
  int columns_per_sweep() const { return window_; }

  /// Column of a sweep, counted from the cut.
  int index(int measurement_id) const { return (measurement_id - first_ + columns_) % columns_; }

  /// Place of a column in the turn that began with measurement id 0.
  int64_t place(int64_t turn, int measurement_id) const {
    return (turn - (measurement_id < first_ ? 1 : 0)) * columns_ + index(measurement_id);
  }

  /// Sweep to which a place belongs.
  int64_t sweep(int64_t place) const {
    return place >= 0 ? place / columns_ : -((columns_ - 1 - place) / columns_);
  }

  /// Number of columns that the sensor sends at the places `from` … `to` − 1; 0 if `to` is smaller.
  int64_t expected(int64_t from, int64_t to) const {
    return std::max<int64_t>(sent_before(to) - sent_before(from), 0);
  }

 private:
  int64_t sent_before(int64_t place) const {
    return sweep(place) * window_ + std::min<int64_t>(place - sweep(place) * columns_, window_);
  }

  int columns_;
  int first_;   ///< measurement id of index 0
  int window_;  ///< columns that the sensor sends, from index 0
};

}  // namespace infuse::ouster
