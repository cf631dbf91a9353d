#pragma once

#include <iosfwd>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/study/registration/recorded_scans.hpp"

namespace infuse::study {

/// Error of an alignment against the truth.
struct AlignmentError {
  bool usable = false;
  double translation = 0;            ///< m
  double rotation = 0;               ///< rad
  std::optional<double> normalised;  ///< squared, over the covariance, a direction, if stated
};

/// P table 4.1: errors of GICP from the identity, of RANSAC on image features alone, of VB-GICP and
/// of mutual information, by the number of scans between target and source.
class AlignmentTable {
 public:
  /// Aligns a source to a target by all methods, into the rows of `scans`. Throws
  /// std::runtime_error.
  void add(const std::vector<CameraMount>& cameras, const PosedScan& target,
           const PosedScan& source, size_t scans);

  /// Writes the table: of the usable results their number, how many are wrong by more than 0.5 m or
  /// 1°, median and maximum, and of the others the squared error over the covariance. RANSAC states
  /// no covariance.
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

/// The table for a recorded drive: every `step`-th sweep from the second one (the motion of the
/// first is not known) with each of the 20 after it, in rows of 1 to 5, 6 to 10, 11 to 15 and 16 to
/// 20 sweeps. Throws std::runtime_error.
AlignmentTable recorded_alignment_table(const RecordedScans& recorded, size_t step);

/// Errors of VB-GICP that need no reference: of sweep a to b, b to c and a to c, `length` sweeps
/// apart, around the cycle, over the sum of their covariances. What is wrong with a sweep itself
/// does not show. Throws std::runtime_error.
std::string cycle_errors(const RecordedScans& recorded, size_t length);

}  // namespace infuse::study
