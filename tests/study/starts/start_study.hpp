#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "fusion/streetmap/global_start.hpp"
#include "tests/study/starts/street_network.hpp"

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
  double turned = 0;     ///< rad, sum of the turns so far
  double elsewhere = 1;  ///< as `FoundPlace`
  double misfit = 0;     ///< as `FoundPlace`
  double alone = 0;      ///< m, as `FoundPlace`
  double sigma = 0;      ///< m
  double behind = 0;     ///< log-weight of the likeliest less that of the truth; infinite: dropped
};

/// What a start waits for.
enum class StartWait { kNothing, kTruthDropped, kOtherLikelier, kOthers, kMisfit, kSigma, kAlone };

/// A start from nothing.
struct StartTrial {
  std::vector<StartMark> marks;  ///< every 10 m
  int turns_500 = 0;             ///< turns of 45° and more within the first 500 m
  double sure_after = -1;        ///< m driven until first sure; below 0: never
  double wrong_metres = 0;       ///< m driven while sure and wrong
  double seconds = 0;            ///< processor time
  double longest_move = 0;       ///< s, of the slowest motion

  bool right_at(double metres) const;  ///< sure and right then
  /// What it then waits for.
  StartWait waits_at(double metres, const streetmap::GlobalStartOptions& options) const;
};

/// Counts of trials.
struct StartCounts {
  std::vector<StartTrial> trials;

  /// Share sure and right against metres, and the counts that were asked for.
  void write(std::ostream& out, const std::string& what) const;

  /// What starts that are not sure and right wait for after 300, 500 and 1000 m.
  void write_waits(std::ostream& out, const streetmap::GlobalStartOptions& options) const;

  /// All marks as CSV.
  void write_marks(std::ostream& out) const;
};

/// Starts `count` times at random places of a drive that leave room for the length.
void try_starts(const streetmap::SegmentMap& map, const PlanarDrive& drive, int count,
                uint64_t seed, const StartStudyOptions& options, StartCounts& counts);

/// The same in towns of 2 km² drawn at random: seeds from `first_seed` on, `starts` in each.
/// `foreign`: each drive is one through another town, so that nothing that is found is right.
void try_drawn_towns(uint64_t first_seed, int towns, int starts, bool foreign,
                     const StartStudyOptions& options, StartCounts& counts);

/// Map of an OpenStreetMap file.
struct StreetFile {
  std::vector<std::byte> bytes;
  streetmap::SegmentMap map;
  StreetNetwork network;
};
Result<StreetFile> read_streets(const std::string& path);

/// Drive of a recorded trajectory (KITTI's rows) on a map.
Result<PlanarDrive> read_drive(const streetmap::SegmentMap& map, const std::string& trajectory);

/// What `run_start_study` runs.
struct StartStudyRun {
  std::vector<std::string> files;  ///< pairs of a map and a trajectory; with `walks` maps
  int drawn = 0;                   ///< towns drawn at random
  int walks = 0;                   ///< random drives on each map
  int starts = 200;                ///< on each trajectory
  bool foreign = false;            ///< drive along the trajectory or the map of the next file
  uint64_t seed = 40'000;
  std::string marks;  ///< file for all marks; empty: none
  StartStudyOptions options;
};

/// Writes the tables; returns what is wrong, or nothing.
std::string run_start_study(std::ostream& out, const StartStudyRun& run);

}  // namespace infuse::study
