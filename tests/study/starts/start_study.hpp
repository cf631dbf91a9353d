#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "fusion/streetmap/global_start.hpp"
#include "tests/study/starts/drawn_network.hpp"

namespace infuse::study {

/// Settings of the starts.
struct StartStudyOptions {
  double scale_sigma = 0.008;     ///< of measured over true distance, drawn for each start
  double yaw_bias_sigma = 0.001;  ///< rad/s, of the yaw rate, drawn for each start
  double motion_noise = 0.02;     ///< of each motion, as a share of it
  double yaw_rate_noise = 0.005;  ///< rad/s, of each motion
  double length = 1500;           ///< m that each start drives
  streetmap::GlobalStartOptions start;
};

/// What a start knew after some metres.
struct StartMark {
  double metres = 0;
  bool sure = false;    ///< as `FoundPlace::sure`
  bool right = false;   ///< the likeliest place lies within 12 m and 15° of the truth
  bool inside = false;  ///< the truth lies in the 99 % region of the likeliest place
  int hypotheses = 0;
};

/// A start from nothing.
struct StartTrial {
  std::vector<StartMark> marks;  ///< every 50 m
  int turns_500 = 0;             ///< turns of 45° and more within the first 500 m
  double sure_after = -1;        ///< m driven until first sure; below 0: never
  double wrong_metres = 0;       ///< m driven while sure and wrong
  double seconds = 0;            ///< processor time
  double longest_move = 0;       ///< s, of the slowest motion

  bool right_at(double metres) const;  ///< sure and right then
};

/// Counts of trials.
struct StartCounts {
  std::vector<StartTrial> trials;

  /// Share sure and right against metres, and the counts that were asked for.
  void write(std::ostream& out, const std::string& what) const;
};

/// Starts `count` times at random places of a drive that leave room for the length.
void try_starts(const streetmap::SegmentMap& map, const PlanarDrive& drive, int count,
                uint64_t seed, const StartStudyOptions& options, StartCounts& counts);

/// The same in towns of 2 km² drawn at random: seeds from `first_seed` on, `starts` in each.
/// `foreign`: each drive is one through another town, so that nothing that is found is right.
void try_drawn_towns(uint64_t first_seed, int towns, int starts, bool foreign,
                     const StartStudyOptions& options, StartCounts& counts);

/// Map of an OpenStreetMap file and the drive of a recorded trajectory on it.
struct RecordedRoute {
  std::vector<std::byte> bytes;
  streetmap::SegmentMap map;
  PlanarDrive drive;
};
Result<RecordedRoute> read_route(const std::string& map, const std::string& trajectory);

}  // namespace infuse::study
