#pragma once

#include <cstddef>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/measurement/error.hpp"

namespace infuse::recording {

/// One quantity of a PCD file's points.
struct PcdField {
  std::string name;
  char type = 'F';   ///< F float, I signed, U unsigned
  size_t size = 4;   ///< bytes of a value: 1, 2, 4, 8; a float 4 or 8
  size_t count = 1;  ///< values a point

  size_t bytes() const { return size * count; }
};

/// How the points are written.
enum class PcdData { kAscii, kBinary, kBinaryCompressed };

/// What the head of a PCD file says (Point Cloud Library, version 0.7 and before).
struct PcdHeader {
  std::vector<PcdField> fields;
  size_t points = 0;
  PcdData data = PcdData::kAscii;
  size_t data_offset = 0;  ///< bytes of the head: where the points begin

  size_t point_bytes() const;
  /// Index of the first of the names that is a field of one value, or −1.
  int find(std::initializer_list<std::string_view> names) const;
};

/// Reads the head. At most 64 fields, 1024 values a point and 4 million points. An error's `where`
/// is the line.
Result<PcdHeader> parse_pcd_header(std::string_view bytes);

}  // namespace infuse::recording
