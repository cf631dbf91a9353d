#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fusion/streetmap/street_hypothesis.hpp"

namespace infuse::streetmap {

/// Where on a large map the drive fits, of which hypotheses everywhere would be too many. The drive
/// is kept until it has turned; then hypotheses begin before the turn on all streets, block by
/// block, and drive to the end. The few that are still on streets are left. Where they are too
/// many, the search waits for one more turn.
class StreetSeeds {
 public:
  /// Along a street, m: seeds are nearer than a street is found across a hypothesis.
  static constexpr double kSpacing = StreetGrid::kProfileReach;

  /// Allocates all memory.
  explicit StreetSeeds(const GlobalStartOptions& options);

  static constexpr size_t kMaxTrack =
      1024;  ///< stretches of the drive that are kept; bounds memory

  /// Forgets the drive.
  void restart();

  /// Adds a stretch of the drive.
  void add(const DriveStretch& stretch);

  /// Goes on by about `comparisons` with the streets of a map, always the same. True once all are
  /// compared.
  bool search(const StreetGrid& grid, int comparisons);

  /// True while a search goes on; else it begins with the next stretch at the earliest.
  bool is_running() const { return running_; }

  /// The hypotheses that are left, which the caller may take away.
  std::vector<StreetHypothesis>& found() { return found_; }
  /// The drive that they have not been compared after.
  std::span<const DriveStretch> since() const { return std::span(track_).subspan(end_); }

 private:
  bool begin();
  int compare_block(const StreetGrid& grid, int block_column, int block_row);
  int drive(const StreetGrid& grid, StreetHypothesis hypothesis);

  GlobalStartOptions options_;
  std::vector<DriveStretch> track_;
  std::vector<StreetHypothesis> found_;
  int turns_ = 1;               // that the drive must have
  bool running_ = false;        // hypotheses are compared
  size_t begin_ = 0, end_ = 0;  // stretches that they are compared after
  int block_ = 0;               // the next
};

}  // namespace infuse::streetmap
