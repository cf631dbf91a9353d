#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"

namespace infuse::importers {

/// A variable of a MAT-file, or a field of one.
struct MatArray {
  size_t rows = 0, columns = 0;
  std::vector<double> numbers;  ///< column by column; empty if it is not numeric, or not wanted
  std::map<std::string, std::vector<MatArray>> fields;  ///< of a structure: one per element

  /// The number at a row and column; NaN if it is not there.
  double at(size_t row, size_t column) const;
  /// The only element of a field; null if there is no such field or element.
  const MatArray* field(const std::string& name, size_t element = 0) const;
};

/// Reads a MAT-file of level 5 (MATLAB's versions 5 to 7): real numeric arrays of two dimensions
/// and structures of them, compressed or not. Cells, texts and sparse matrices are skipped. Arrays
/// other than `wanted` names have their size, but no numbers; with an empty set all have. Memory is
/// bounded by 256 MiB. Errors: another format, a file that is damaged. `name` is that of the file.
Result<std::map<std::string, MatArray>> read_mat(std::span<const uint8_t> bytes,
                                                 const std::string& name,
                                                 const std::set<std::string>& wanted = {});

}  // namespace infuse::importers
