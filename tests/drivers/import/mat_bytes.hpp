#pragma once

#include <zlib.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace infuse::importers {

/// Parts of MAT-files of level 5, as MATLAB's description of the format states them.
template <class Number>
std::string mat_number(Number value) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  return bytes;
}

inline std::string mat_element(uint32_t type, const std::string& data) {
  std::string bytes = mat_number(type) + mat_number(static_cast<uint32_t>(data.size())) + data;
  bytes.resize((bytes.size() + 7) / 8 * 8, '\0');
  return bytes;
}

inline std::string mat_matrix(uint32_t kind, int rows, int columns, const std::string& name,
                              const std::string& content) {
  return mat_element(14, mat_element(6, mat_number(kind) + mat_number(uint32_t{0})) +
                             mat_element(5, mat_number(rows) + mat_number(columns)) +
                             mat_element(1, name) + content);
}

/// A matrix of doubles, given column by column.
inline std::string mat_doubles(int rows, int columns, const std::vector<double>& numbers,
                               const std::string& name = "") {
  std::string data;
  for (const double number : numbers) data += mat_number(number);
  return mat_matrix(6, rows, columns, name, mat_element(9, data));
}

/// A structure of `columns` elements; `fields` are those of the elements one after the other.
inline std::string mat_structure(int columns, const std::vector<std::string>& names,
                                 const std::string& fields, const std::string& name) {
  constexpr size_t kWidth = 32;
  std::string all_names;
  for (const std::string& each : names) {
    std::string padded = each;
    padded.resize(kWidth, '\0');
    all_names += padded;
  }
  // The width is a small element: length and type in one word, data in the next.
  const std::string width = mat_number(uint32_t{4} << 16 | 5) + mat_number(int32_t{kWidth});
  return mat_matrix(2, 1, columns, name, width + mat_element(1, all_names) + fields);
}

inline std::string mat_file(const std::string& variables) {
  std::string header = "MATLAB 5.0 MAT-file, written by a test";
  header.resize(124, ' ');
  return header + mat_number(uint16_t{0x0100}) + "IM" + variables;
}

inline std::string mat_compressed(const std::string& variable) {
  uLongf length = compressBound(static_cast<uLong>(variable.size()));
  std::string bytes(length, '\0');
  compress(reinterpret_cast<Bytef*>(bytes.data()), &length,
           reinterpret_cast<const Bytef*>(variable.data()), static_cast<uLong>(variable.size()));
  bytes.resize(length);
  return mat_number(uint32_t{15}) + mat_number(static_cast<uint32_t>(bytes.size())) + bytes;
}

}  // namespace infuse::importers
