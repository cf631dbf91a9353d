#include "drivers/import/mat_file.hpp"

#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>

namespace infuse::importers {
namespace {

constexpr size_t kMatHeader = 128;
constexpr size_t kMaxMatBytes = size_t{256} << 20;
constexpr size_t kMaxMatElements = 100'000;  // of structures, all together
constexpr int kMaxMatDepth = 8;

enum ElementType : uint32_t {
  kInt8 = 1,
  kUint8 = 2,
  kInt16 = 3,
  kUint16 = 4,
  kInt32 = 5,
  kUint32 = 6,
  kSingle = 7,
  kDouble = 9,
  kInt64 = 12,
  kUint64 = 13,
  kMatrix = 14,
  kCompressed = 15,
};
constexpr uint32_t kStructClass = 2, kFirstNumericClass = 6, kLastNumericClass = 15;

template <class Number>
Number number_at(std::span<const uint8_t> bytes, size_t at) {
  Number value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

struct Element {
  uint32_t type = 0;
  std::span<const uint8_t> data;
};

/// Takes the next element; nothing if the bytes end before it does.
std::optional<Element> next_element(std::span<const uint8_t>& rest) {
  if (rest.size() < 8) return std::nullopt;
  const auto head = number_at<uint32_t>(rest, 0);
  if (head >> 16 != 0) {  // small: type and length in four bytes, data in the next four
    const size_t length = head >> 16;
    if (length > 4) return std::nullopt;
    const Element element{head & 0xFFFF, rest.subspan(4, length)};
    rest = rest.subspan(8);
    return element;
  }
  const auto length = number_at<uint32_t>(rest, 4);
  if (length > rest.size() - 8) return std::nullopt;
  const Element element{head, rest.subspan(8, length)};
  const size_t padded = head == kCompressed ? length : (size_t{length} + 7) / 8 * 8;
  rest = rest.subspan(8 + std::min(padded, rest.size() - 8));
  return element;
}

template <class Number>
void append_numbers(std::span<const uint8_t> data, std::vector<double>& numbers) {
  numbers.reserve(data.size() / sizeof(Number));
  for (size_t at = 0; at + sizeof(Number) <= data.size(); at += sizeof(Number))
    numbers.push_back(static_cast<double>(number_at<Number>(data, at)));
}

bool read_numbers(const Element& element, std::vector<double>& numbers) {
  switch (element.type) {
    case kInt8:
      append_numbers<int8_t>(element.data, numbers);
      return true;
    case kUint8:
      append_numbers<uint8_t>(element.data, numbers);
      return true;
    case kInt16:
      append_numbers<int16_t>(element.data, numbers);
      return true;
    case kUint16:
      append_numbers<uint16_t>(element.data, numbers);
      return true;
    case kInt32:
      append_numbers<int32_t>(element.data, numbers);
      return true;
    case kUint32:
      append_numbers<uint32_t>(element.data, numbers);
      return true;
    case kSingle:
      append_numbers<float>(element.data, numbers);
      return true;
    case kDouble:
      append_numbers<double>(element.data, numbers);
      return true;
    case kInt64:
      append_numbers<int64_t>(element.data, numbers);
      return true;
    case kUint64:
      append_numbers<uint64_t>(element.data, numbers);
      return true;
    default:
      return false;
  }
}

/// Bytes of a number of that type; 0 for other types.
size_t size_of(uint32_t type) {
  switch (type) {
    case kInt8:
    case kUint8:
      return 1;
    case kInt16:
    case kUint16:
      return 2;
    case kInt32:
    case kUint32:
    case kSingle:
      return 4;
    case kDouble:
    case kInt64:
    case kUint64:
      return 8;
    default:
      return 0;
  }
}

std::string name_in(std::span<const uint8_t> data) {
  const auto end = std::ranges::find(data, uint8_t{0});
  return {data.begin(), end};
}

class MatReader {
 public:
  explicit MatReader(const std::set<std::string>& wanted) : wanted_(wanted) {}

  /// Reads a matrix. False if it is damaged or too large.
  bool read_matrix(std::span<const uint8_t> data, const std::string& field_name, int depth,
                   std::string& name, MatArray& array) {
    if (data.empty()) return true;  // an empty matrix may be left out
    if (depth > kMaxMatDepth) return false;
    const auto flags = next_element(data);
    const auto dimensions = next_element(data);
    const auto own_name = next_element(data);
    if (!flags || !dimensions || !own_name || flags->data.size() < 8) return false;
    if (dimensions->data.size() < 8) return false;
    name = name_in(own_name->data);
    const auto rows = number_at<int32_t>(dimensions->data, 0);
    const auto columns = number_at<int32_t>(dimensions->data, 4);
    if (rows < 0 || columns < 0) return false;
    array.rows = static_cast<size_t>(rows);
    array.columns = static_cast<size_t>(columns);
    const uint32_t kind = number_at<uint32_t>(flags->data, 0) & 0xFF;
    if (kind == kStructClass) return read_structure(data, depth, array);
    if (kind < kFirstNumericClass || kind > kLastNumericClass) return true;  // skipped
    if (dimensions->data.size() > 8) return true;  // more than two dimensions: skipped
    const auto real = next_element(data);
    if (!real) return false;
    const size_t size = size_of(real->type);
    if (size == 0 || real->data.size() / size != array.rows * array.columns) return false;
    const std::string& known_as = field_name.empty() ? name : field_name;
    if (!wanted_.empty() && !wanted_.contains(known_as)) return true;
    bytes_ += real->data.size() / size * sizeof(double);
    return bytes_ <= kMaxMatBytes && read_numbers(*real, array.numbers);
  }

 private:
  bool read_structure(std::span<const uint8_t> data, int depth, MatArray& array) {
    const auto length = next_element(data);
    const auto names = next_element(data);
    if (!length || !names || length->data.size() < 4) return false;
    const auto width = number_at<int32_t>(length->data, 0);
    if (width < 1 || width > 64) return false;
    const auto name_bytes = static_cast<size_t>(width);
    const size_t fields = names->data.size() / name_bytes;
    const size_t count = array.rows * array.columns;
    if (array.rows > kMaxMatElements || array.columns > kMaxMatElements) return false;
    for (size_t element = 0; element < count; ++element) {
      for (size_t k = 0; k < fields; ++k) {
        if (++elements_ > kMaxMatElements) return false;
        const auto field = next_element(data);
        if (!field || field->type != kMatrix) return false;
        const std::string name = name_in(names->data.subspan(k * name_bytes, name_bytes));
        std::string own;
        if (!read_matrix(field->data, name, depth + 1, own, array.fields[name].emplace_back()))
          return false;
      }
    }
    return true;
  }

  const std::set<std::string>& wanted_;
  size_t bytes_ = 0, elements_ = 0;
};

/// Inflates an element. Nothing if it is damaged or larger than the limit.
std::optional<std::vector<uint8_t>> inflate_element(std::span<const uint8_t> data) {
  constexpr size_t kStep = size_t{1} << 20;
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) return std::nullopt;
  std::vector<uint8_t> out;
  stream.next_in = const_cast<uint8_t*>(data.data());
  stream.avail_in = static_cast<uInt>(data.size());
  int state = Z_OK;
  while (state == Z_OK && out.size() < kMaxMatBytes) {
    const size_t before = out.size();
    out.resize(before + kStep);
    stream.next_out = out.data() + before;
    stream.avail_out = static_cast<uInt>(kStep);
    state = inflate(&stream, Z_NO_FLUSH);
    out.resize(before + kStep - stream.avail_out);
    if (stream.avail_in == 0 && stream.avail_out > 0) break;
  }
  inflateEnd(&stream);
  if (state != Z_STREAM_END) return std::nullopt;
  return out;
}

}  // namespace

double MatArray::at(size_t row, size_t column) const {
  if (row >= rows || column >= columns || numbers.size() != rows * columns)
    return std::numeric_limits<double>::quiet_NaN();
  return numbers[column * rows + row];
}

const MatArray* MatArray::field(const std::string& name, size_t element) const {
  const auto found = fields.find(name);
  if (found == fields.end() || element >= found->second.size()) return nullptr;
  return &found->second[element];
}

Result<std::map<std::string, MatArray>> read_mat(std::span<const uint8_t> bytes,
                                                 const std::string& name,
                                                 const std::set<std::string>& wanted) {
  const auto begins = [&](std::string_view text) {
    return bytes.size() >= text.size() && std::memcmp(bytes.data(), text.data(), text.size()) == 0;
  };
  if (begins("MATLAB 7.3"))
    return fail("is a MAT-file of version 7.3", name, "save it with -v7 in MATLAB");
  if (bytes.size() < kMatHeader || !begins("MATLAB 5.0 MAT-file"))
    return fail("is not a MAT-file of level 5", name);
  if (bytes[126] != 'I' || bytes[127] != 'M')
    return fail("is a MAT-file of a big-endian computer", name, "save it again on another one");
  std::map<std::string, MatArray> variables;
  MatReader reader(wanted);
  auto rest = bytes.subspan(kMatHeader);
  while (!rest.empty()) {
    auto element = next_element(rest);
    if (!element) return fail("ends within a variable", name);
    std::optional<std::vector<uint8_t>> inflated;
    if (element->type == kCompressed) {
      inflated = inflate_element(element->data);
      if (!inflated) return fail("has a variable that cannot be decompressed", name);
      std::span<const uint8_t> inner(*inflated);
      element = next_element(inner);
      if (!element) return fail("has a damaged variable", name);
    }
    if (element->type != kMatrix) continue;
    std::string variable;
    MatArray array;
    if (!reader.read_matrix(element->data, "", 0, variable, array))
      return fail("has a variable that is damaged or too large", name, variable);
    variables[variable] = std::move(array);
  }
  return variables;
}

}  // namespace infuse::importers
