#include "drivers/recording/pcd_header.hpp"

#include <optional>
#include <span>

#include "drivers/text/numbers.hpp"

namespace infuse::recording {
namespace {

constexpr size_t kMaxPointFields = 64;
constexpr size_t kMaxValuesPerPoint = 1024;
constexpr size_t kMaxPoints = 4'000'000;
constexpr size_t kMaxHeaderLines = 100;
constexpr size_t kMaxLineBytes = 4096;

std::vector<std::string_view> split_words(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::string_view word; !(word = text::next_word(line)).empty();) words.push_back(word);
  return words;
}

std::optional<size_t> parse_unsigned(std::string_view word, size_t max_value) {
  const auto value = text::parse_as<size_t>(word);
  return value && *value <= max_value ? value : std::nullopt;
}

std::optional<PcdData> parse_data(std::string_view word) {
  if (word == "ascii") return PcdData::kAscii;
  if (word == "binary") return PcdData::kBinary;
  if (word == "binary_compressed") return PcdData::kBinaryCompressed;
  return std::nullopt;
}

/// Parses a header line by line.
class HeaderReader {
 public:
  /// Parses one line. Returns what is invalid, or an empty string.
  std::string read_line(std::span<const std::string_view> words) {
    const std::string_view key = words.front();
    const auto values = words.subspan(1);
    if (key == "FIELDS" || key == "COLUMNS") return read_fields(values);
    if (key == "SIZE" || key == "TYPE" || key == "COUNT") return read_each(key, values);
    if (key == "WIDTH" || key == "HEIGHT" || key == "POINTS") {
      const auto number =
          values.size() == 1 ? parse_unsigned(values[0], kMaxPoints) : std::optional<size_t>();
      if (!number) return "must be one number up to " + std::to_string(kMaxPoints);
      (key == "WIDTH" ? width_ : key == "HEIGHT" ? height_ : points_) = *number;
      return {};
    }
    if (key == "DATA") {
      const auto data = values.size() == 1 ? parse_data(values[0]) : std::optional<PcdData>();
      if (!data) return "must be ascii, binary or binary_compressed";
      header_.data = *data;
      return finish();
    }
    if (key == "VERSION" || key == "VIEWPOINT") return {};
    return "is not a key of a PCD header";
  }

  const PcdHeader& header() const { return header_; }

 private:
  std::string read_fields(std::span<const std::string_view> names) {
    if (names.empty() || names.size() > kMaxPointFields) {
      return "must name 1 to " + std::to_string(kMaxPointFields) + " fields";
    }
    header_.fields.clear();
    for (const std::string_view name : names) header_.fields.push_back({.name = std::string(name)});
    return {};
  }

  std::string read_each(std::string_view key, std::span<const std::string_view> words) {
    if (words.size() != header_.fields.size()) return "must have one entry per field";
    for (size_t i = 0; i < words.size(); ++i) {
      PcdField& field = header_.fields[i];
      if (key == "TYPE") {
        if (words[i] != "F" && words[i] != "I" && words[i] != "U") return "must be F, I or U";
        field.type = words[i][0];
        continue;
      }
      const auto number = parse_unsigned(words[i], kMaxValuesPerPoint);
      if (!number || *number == 0) return "must be positive integers";
      (key == "SIZE" ? field.size : field.count) = *number;
    }
    return {};
  }

  std::string finish() {
    if (header_.fields.empty()) return "comes before FIELDS";
    size_t values = 0;
    for (const PcdField& field : header_.fields) {
      const bool whole = field.size == 1 || field.size == 2 || field.size == 4 || field.size == 8;
      if (!whole || (field.type == 'F' && field.size < 4)) {
        return "follows a field '" + field.name + "' whose size does not fit its type";
      }
      values += field.count;
    }
    if (values > kMaxValuesPerPoint) return "follows fields with more than 1024 values per point";
    if (!points_ && !width_) return "comes before POINTS";
    header_.points = points_ ? *points_ : *width_;
    const size_t shape = width_ ? *width_ * height_.value_or(1) : header_.points;
    if (shape != header_.points) return "follows a WIDTH and HEIGHT that contradict POINTS";
    return {};
  }

  PcdHeader header_;
  std::optional<size_t> width_, height_, points_;
};

}  // namespace

size_t PcdHeader::point_bytes() const {
  size_t sum = 0;
  for (const PcdField& field : fields) sum += field.bytes();
  return sum;
}

int PcdHeader::find(std::initializer_list<std::string_view> names) const {
  for (const std::string_view name : names) {
    for (size_t i = 0; i < fields.size(); ++i) {
      if (fields[i].name == name && fields[i].count == 1) return static_cast<int>(i);
    }
  }
  return -1;
}

Result<PcdHeader> parse_pcd_header(std::string_view bytes) {
  HeaderReader reader;
  size_t at = 0;
  for (size_t number = 1; number <= kMaxHeaderLines; ++number) {
    const size_t length = bytes.substr(at, kMaxLineBytes).find('\n');
    const std::string where = "line " + std::to_string(number);
    if (length == std::string_view::npos) {
      return fail("the header has no DATA line", where, "expected a PCD file");
    }
    const auto words = split_words(bytes.substr(at, length));
    at += length + 1;
    if (words.empty() || words.front().starts_with('#')) continue;
    if (std::string wrong = reader.read_line(words); !wrong.empty()) {
      return fail(std::string(words.front().substr(0, 32)) + " " + wrong, where);
    }
    if (words.front() != "DATA") continue;
    PcdHeader header = reader.header();
    header.data_offset = at;
    return header;
  }
  return fail("the header has more than 100 lines", {}, "expected a PCD file");
}

}  // namespace infuse::recording
