#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"

namespace infuse::recording {

/// A text of "KEY: numbers" a line, as data sets publish their calibration. Lines whose value is no
/// list of numbers (calib_time) are passed over.
class CalibrationText {
 public:
  static Result<CalibrationText> read(const std::filesystem::path& path);

  /// The numbers of the first of `keys` that the file has, or null.
  const std::vector<double>* find(std::initializer_list<const char*> keys) const;

  /// rows × columns numbers by row, in the corner of a 4 × 4 identity.
  Result<Eigen::Matrix4d> matrix(std::initializer_list<const char*> keys, int rows,
                                 int columns) const;

  /// 3 × columns numbers as a rigid motion (`to_rigid`).
  Result<Eigen::Isometry3d> rigid(std::initializer_list<const char*> keys, int columns) const;

  /// The file's path.
  const std::string& name() const { return name_; }

 private:
  std::string name_;
  std::map<std::string, std::vector<double>> values_;
};

}  // namespace infuse::recording
