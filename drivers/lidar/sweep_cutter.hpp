#pragma once

#include <array>
#include <cstdint>

#include "drivers/lidar/azimuth.hpp"
#include "drivers/lidar/firing_plan.hpp"

namespace infuse::lidar {

/// Mean rate of rotation over the last seconds.
class RotationRate {
 public:
  /// Adds an angle (0.01°) and the time in which the sensor turned by it.
  void add(int64_t advance, int64_t time_ns) {
    turned_ += advance;
    time_ns_ += time_ns;
    if (time_ns_ < kMemoryNs) return;
    turned_ /= 2;
    time_ns_ /= 2;
  }

  /// 0.01° per ns; 0 while unknown.
  double per_ns() const {
    return time_ns_ > 0 ? static_cast<double>(turned_) / static_cast<double>(time_ns_) : 0;
  }

 private:
  static constexpr int64_t kMemoryNs = 2'000'000'000;
  int64_t turned_ = 0;
  int64_t time_ns_ = 0;
};

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

  /// Processes a sequence after lost packets and the part that the sensor does not scan: a new
  /// sweep begins, but its edges are not those of that part.
  bool process_lossy_jump(int azimuth);

  /// Processes the sequences of a packet; `lossy_jump`: the first one so. Sets for each whether a
  /// new sweep begins with it.
  void process_packet(const FiringPlan& plan, bool lossy_jump,
                      std::array<bool, kMaxSequences>& begins);

  /// Starts over: the next sequence has no relation to earlier ones.
  void restart() { started_ = false; }

  /// True if the sensor scans a part of the turn only.
  bool partial_turn() const { return partial_turn_; }

  /// True if a step between these azimuths is the one over the part that the sensor does not scan.
  bool is_known_jump(int from, int to) const;

  /// Time, ns, in which a sensor that turns at this rate passes the part that it does not scan,
  /// during a gap of `gap_ns` after the sequence at `from` (0.01°); 0 if it scans the whole turn.
  int64_t pause_within(int from, int64_t gap_ns, int64_t period_ns,
                       const RotationRate& rotation) const;

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

}  // namespace infuse::lidar
