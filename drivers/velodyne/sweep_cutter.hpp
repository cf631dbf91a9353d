#pragma once

#include <cstdint>

#include "drivers/velodyne/firing_plan.hpp"

namespace infuse::velodyne {

/// Says where a sweep ends: at the cut azimuth, or, where the sensor looks at a part of the turn
/// only, where that part ends.
class SweepCutter {
 public:
  /// `cut_azimuth` in 0.01°, 0 … 35999.
  explicit SweepCutter(int cut_azimuth) : cut_azimuth_(cut_azimuth) {}

  /// Takes the next firing sequence: its azimuth (0.01°), how far the sensor has turned since the
  /// one before (0.01°, over lost packets more than a turn, backward negative) and whether it
  /// jumped there. True where a new sweep begins with it.
  bool process_sequence(int azimuth, int64_t advance, bool after_jump);

  /// The next sequence has no relation to those before.
  void restart() { started_ = false; }

  /// The sensor looks at a part of the turn.
  bool partial_turn() const { return partial_turn_; }

  /// Whether a step from azimuth to azimuth is the one over what the sensor does not look at.
  bool is_known_jump(int from, int to) const;

 private:
  void start(int azimuth);

  int cut_azimuth_;
  bool started_ = false;
  bool partial_turn_ = false;
  int azimuth_ = 0;                  ///< of the last sequence
  int64_t to_cut_ = 0;               ///< 0.01° until the cut azimuth comes again
  int64_t since_jump_ = 0;           ///< 0.01° turned since the last jump
  int jump_from_ = 0, jump_to_ = 0;  ///< 0.01°
};

}  // namespace infuse::velodyne
