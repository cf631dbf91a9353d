#include "drivers/recording/ply_sweep.hpp"

#include <array>
#include <charconv>

#include "drivers/recording/pcd_sweep.hpp"
#include "drivers/text/numbers.hpp"

namespace infuse::recording {
namespace {

constexpr size_t kMaxPlyFields = 64;
constexpr size_t kMaxPlyPoints = 4'000'000;
constexpr size_t kMaxLines = 1000;

struct ScalarType {
  std::string_view name;
  char type;
  size_t size;
};
constexpr std::array<ScalarType, 16> kTypes{{{"char", 'I', 1},
                                             {"uchar", 'U', 1},
                                             {"short", 'I', 2},
                                             {"ushort", 'U', 2},
                                             {"int", 'I', 4},
                                             {"uint", 'U', 4},
                                             {"float", 'F', 4},
                                             {"double", 'F', 8},
                                             {"int8", 'I', 1},
                                             {"uint8", 'U', 1},
                                             {"int16", 'I', 2},
                                             {"uint16", 'U', 2},
                                             {"int32", 'I', 4},
                                             {"uint32", 'U', 4},
                                             {"float32", 'F', 4},
                                             {"float64", 'F', 8}}};

/// Adds a property of the points.
bool add_field(std::string_view line, PcdHeader& header) {
  const std::string_view type = text::next_word(line);
  std::string_view name = text::next_word(line);
  constexpr std::string_view kPrefix = "scalar_";
  if (name.starts_with(kPrefix)) name.remove_prefix(kPrefix.size());
  for (const ScalarType& known : kTypes) {
    if (known.name != type || name.empty() || header.fields.size() == kMaxPlyFields) continue;
    header.fields.push_back({.name = std::string(name), .type = known.type, .size = known.size});
    return true;
  }
  return false;
}

bool read_count(std::string_view word, size_t& count) {
  const auto [end, failed] = std::from_chars(word.data(), word.data() + word.size(), count);
  return failed == std::errc() && end == word.data() + word.size() && count <= kMaxPlyPoints;
}

}  // namespace

Result<PcdHeader> parse_ply_header(std::string_view bytes) {
  PcdHeader header;
  bool has_format = false, has_points = false, in_points = false;
  size_t begin = 0;
  for (size_t number = 1; number <= kMaxLines; ++number) {
    const size_t end = bytes.find('\n', begin);
    if (end == std::string_view::npos) break;
    std::string_view line = bytes.substr(begin, end - begin);
    if (line.ends_with('\r')) line.remove_suffix(1);
    begin = end + 1;
    const auto wrong = [&](const char* what) {
      return fail(what, "line " + std::to_string(number));
    };
    const std::string_view key = text::next_word(line);
    if (number == 1) {
      if (key != "ply") return wrong("is not a PLY file");
    } else if (key == "format") {
      const std::string_view format = text::next_word(line);
      if (format != "ascii" && format != "binary_little_endian") {
        return wrong("format must be ascii or binary_little_endian");
      }
      header.data = format == "ascii" ? PcdData::kAscii : PcdData::kBinary;
      has_format = true;
    } else if (key == "element") {
      in_points = text::next_word(line) == "vertex";
      if (!has_points && !in_points) return wrong("the first element must be vertex");
      if (in_points && (has_points || !read_count(text::next_word(line), header.points))) {
        return wrong("vertex needs a number of at most 4 million points");
      }
      has_points = true;
    } else if (key == "property") {
      if (in_points && !add_field(line, header)) {
        return wrong("property must be a number type and a name, at most 64 of them");
      }
    } else if (key == "end_header") {
      if (!has_format || !has_points) return wrong("header has no format or no element vertex");
      header.data_offset = begin;
      return header;
    } else if (key != "comment" && key != "obj_info") {
      return wrong("unknown line of a header");
    }
  }
  return fail("has no end_header");
}

Result<void> parse_ply_sweep(std::string_view bytes, Sweep& sweep) {
  const auto header = parse_ply_header(bytes);
  if (!header) return tl::unexpected(header.error());
  return parse_points(*header, bytes.substr(header->data_offset), sweep);
}

}  // namespace infuse::recording
