#pragma once

#include <cstdint>

#include "drivers/velodyne/firing_plan.hpp"

namespace infuse::velodyne {

/// Determines where a sweep ends: at the cut azimuth, or, if the sensor scans a part of the turn
/// only, at the end of that part.
class SweepCutter {
 public:
  /// `cut_azimuth` in 0.01°, 0 … 35999.
  explicit SweepCutter(int cut_azimuth) : cut_azimuth_(cut_azimuth) {}

  /// Processes the next firing sequence: its azimuth (0.01°), the angle turned since the previous
  /// one (0.01°, over lost packets more than a turn, backwards negative) and whether it jumped
  /// there. True if a new sweep begins with it.
  bool process_sequence(int azimuth, int64_t advance, bool after_jump);

  /// Starts over: the next sequence has no relation to earlier ones.
  void restart() { started_ = false; }

  /// True if the sensor scans a part of the turn only.
  bool partial_turn() const { return partial_turn_; }

  /// True if a step between these azimuths is the one over the part that the sensor does not scan.
  bool is_known_jump(int from, int to) const;

 private:
  void start(int azimuth);

  int cut_azimuth_;
  bool started_ = false;
  bool partial_turn_ = false;
  int azimuth_ = 0;                  ///< of the last sequence
  int64_t to_cut_ = 0;               ///< 0.01° until the cut azimuth
  int64_t since_jump_ = 0;           ///< 0.01° turned since the last jump
  int jump_from_ = 0, jump_to_ = 0;  ///< 0.01°
};

}  // namespace infuse::velodyne
