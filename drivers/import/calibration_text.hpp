#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"

namespace infuse::importers {

/// A calibration file of a public data set: lines "KEY: numbers". Lines whose value is not a list
/// of numbers (calib_time) are skipped.
class CalibrationText {
 public:
  /// Reads a file; fails if it cannot be opened.
  static Result<CalibrationText> read(const std::filesystem::path& path);

  /// Returns the numbers of the first of `keys` that the file contains, or null.
  const std::vector<double>* find(std::initializer_list<const char*> keys) const;

  /// Returns rows × columns numbers, given by row, as the upper left block of a 4 × 4 identity.
  Result<Eigen::Matrix4d> matrix(std::initializer_list<const char*> keys, int rows,
                                 int columns) const;

  /// Returns 3 × columns numbers as a rigid motion (`to_rigid`).
  Result<Eigen::Isometry3d> rigid(std::initializer_list<const char*> keys, int columns) const;

  /// Path of the file.
  const std::string& name() const { return name_; }

 private:
  std::string name_;
  std::map<std::string, std::vector<double>> values_;
};

}  // namespace infuse::importers
