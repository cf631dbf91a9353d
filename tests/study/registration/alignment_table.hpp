#pragma once

#include <iosfwd>
#include <map>
#include <vector>

#include "tests/study/registration/recorded_scans.hpp"

namespace infuse::study {

/// Error of an alignment against the truth.
struct AlignmentError {
  bool usable = false;
  double translation = 0;  ///< m
  double rotation = 0;     ///< rad
};

/// P table 4.1: errors of GICP from the identity, of RANSAC on image features alone, of VB-GICP and
/// of mutual information, by the number of scans between target and source.
class AlignmentTable {
 public:
  /// Aligns a source to a target `scans` later by all methods. Throws std::runtime_error.
  void add(const std::vector<CameraMount>& cameras, const PosedScan& target,
           const PosedScan& source, size_t scans);

  /// Writes the table: median and maximum of the usable results, and their number.
  void write(std::ostream& out) const;

 private:
  std::map<std::pair<size_t, size_t>, std::vector<AlignmentError>> errors_;  // by scans and method
};

/// Extent of the table on simulated drives.
struct SimulatedTableOptions {
  uint64_t first_seed = 1101;  ///< of the drives: no codebook was learned from them
  int drives = 4;
  double spacing = 0.75;  ///< m, between scans
};

/// The table for a ring of five cameras, over 1, 5, 10 and 15 scans. Throws std::runtime_error.
AlignmentTable simulated_alignment_table(const SimulatedTableOptions& options);

/// The table for a recorded drive: `bases` scans, evenly spread, each against the scans 1, 5, 10
/// and 15 later. Throws std::runtime_error.
AlignmentTable recorded_alignment_table(const RecordedScans& recorded, size_t bases);

}  // namespace infuse::study
