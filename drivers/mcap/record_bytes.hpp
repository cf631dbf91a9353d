#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace infuse::mcap {

static_assert(std::endian::native == std::endian::little, "MCAP files are little-endian");

/// Bytes that begin and end a file.
inline constexpr std::array<uint8_t, 8> kMagic = {0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};
/// Bytes of a record before its content: opcode and length.
inline constexpr size_t kRecordHeader = 9;

/// Kinds of records.
enum class Opcode : uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kAttachment = 0x09,
  kAttachmentIndex = 0x0A,
  kStatistics = 0x0B,
  kMetadata = 0x0C,
  kMetadataIndex = 0x0D,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

/// Reads the fields of a record. What lies behind the end is zero or empty, and `ok` is false then.
class FieldReader {
 public:
  explicit FieldReader(std::span<const uint8_t> bytes) : rest_(bytes) {}

  /// An integer.
  template <class Number>
  Number number() {
    Number value{};
    const auto bytes = take(sizeof value);
    if (bytes.size() == sizeof value) std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }
  /// A text after its length.
  std::string_view text() {
    const auto bytes = take(number<uint32_t>());
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  /// Pairs of texts after their length in bytes.
  std::map<std::string, std::string> pairs() {
    std::map<std::string, std::string> map;
    FieldReader fields(take(number<uint32_t>()));
    while (fields.ok_ && !fields.rest_.empty()) {
      const std::string key(fields.text());
      map.emplace(key, fields.text());
    }
    ok_ = ok_ && fields.ok_;
    return map;
  }
  /// The next `count` bytes; none if there are fewer.
  std::span<const uint8_t> take(uint64_t count) {
    if (count > rest_.size()) {
      ok_ = false;
      rest_ = {};
      return {};
    }
    const auto taken = rest_.first(static_cast<size_t>(count));
    rest_ = rest_.subspan(static_cast<size_t>(count));
    return taken;
  }
  std::span<const uint8_t> rest() const { return rest_; }
  bool ok() const { return ok_; }

 private:
  std::span<const uint8_t> rest_;
  bool ok_ = true;
};

/// Appends the fields of records to a buffer.
class FieldWriter {
 public:
  explicit FieldWriter(std::vector<uint8_t>& bytes) : bytes_(bytes) {}

  template <class Number>
  void number(Number value) {
    const size_t at = bytes_.size();
    bytes_.resize(at + sizeof value);
    std::memcpy(bytes_.data() + at, &value, sizeof value);
  }
  void raw(std::span<const uint8_t> bytes) {
    if (bytes.empty()) return;
    const size_t at = bytes_.size();
    bytes_.resize(at + bytes.size());
    std::memcpy(bytes_.data() + at, bytes.data(), bytes.size());
  }
  void text(std::string_view text) {
    number(static_cast<uint32_t>(text.size()));
    raw({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
  }
  void pairs(const std::map<std::string, std::string>& map) {
    size_t length = 0;
    for (const auto& [key, value] : map) length += 8 + key.size() + value.size();
    number(static_cast<uint32_t>(length));
    for (const auto& [key, value] : map) {
      text(key);
      text(value);
    }
  }
  /// Begins a record. Returns its position for `end_record`.
  size_t begin_record(Opcode opcode) {
    number(opcode);
    number(uint64_t{0});
    return bytes_.size();
  }
  /// Enters the length of the record that `begin_record` began.
  void end_record(size_t begin) {
    const uint64_t length = bytes_.size() - begin;
    std::memcpy(bytes_.data() + begin - sizeof length, &length, sizeof length);
  }

 private:
  std::vector<uint8_t>& bytes_;
};

}  // namespace infuse::mcap
