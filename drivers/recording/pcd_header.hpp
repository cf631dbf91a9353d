#pragma once

#include <cstddef>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/measurement/error.hpp"

namespace infuse::recording {

/// One field of a PCD file's points.
struct PcdField {
  std::string name;
  char type = 'F';   ///< F float, I signed, U unsigned
  size_t size = 4;   ///< bytes per value: 1, 2, 4, 8; for floats 4 or 8
  size_t count = 1;  ///< values per point

  /// Bytes per point.
  size_t bytes() const { return size * count; }
};

/// Encoding of the points.
enum class PcdData { kAscii, kBinary, kBinaryCompressed };

/// Header of a PCD file (Point Cloud Library, version 0.7 and earlier).
struct PcdHeader {
  std::vector<PcdField> fields;
  size_t points = 0;
  PcdData data = PcdData::kAscii;
  size_t data_offset = 0;  ///< size of the header in bytes; the points follow

  /// Bytes per point.
  size_t point_bytes() const;
  /// Index of the field with the first of `names` that is present with one value per point, or −1.
  int find(std::initializer_list<std::string_view> names) const;
};

/// Parses a header of at most 64 fields, 1024 values per point and 4 million points. An error's
/// `where` is the line.
Result<PcdHeader> parse_pcd_header(std::string_view bytes);

}  // namespace infuse::recording
