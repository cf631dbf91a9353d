#include "drivers/recording/record_scan.hpp"

#include <array>
#include <cstdlib>
#include <cstring>
#include <vector>

namespace infuse::recording {
namespace {

constexpr size_t kScannedBytes = size_t{1} << 20;
constexpr size_t kFileHeader = 24, kRecordHeader = 16;
constexpr uint32_t kMaxRecord = 262'144;     // the largest snapshot length of libpcap
constexpr int64_t kMaxSeconds = 7 * 86'400;  // a capture lasts less than a week

uint32_t read_word(const uint8_t* bytes, bool swapped) {
  uint32_t word = 0;
  std::memcpy(&word, bytes, sizeof word);
  return swapped ? __builtin_bswap32(word) : word;
}

}  // namespace

std::optional<RecordScan> RecordScan::of(FILE* file) {
  const off_t place = ftello(file);
  std::array<uint8_t, kFileHeader + kRecordHeader> begin{};
  if (place < 0 || fseeko(file, 0, SEEK_SET) != 0) return std::nullopt;
  const bool read = std::fread(begin.data(), 1, begin.size(), file) == begin.size();
  if (fseeko(file, place, SEEK_SET) != 0 || !read) return std::nullopt;
  RecordScan scan;
  for (const bool swapped : {false, true}) {
    const uint32_t magic = read_word(begin.data(), swapped);
    const bool nano = magic == 0xA1B23C4D;
    if (!nano && magic != 0xA1B2C3D4) continue;
    scan.swapped_ = swapped;
    scan.max_fraction_ = nano ? 1'000'000'000 : 1'000'000;
    scan.first_second_ = read_word(begin.data() + kFileHeader, swapped);
    return scan;
  }
  return std::nullopt;
}

std::optional<int64_t> RecordScan::find_next(FILE* file, int64_t damaged) const {
  std::vector<uint8_t> bytes(kScannedBytes);
  if (fseeko(file, damaged + 1, SEEK_SET) != 0) return std::nullopt;
  bytes.resize(std::fread(bytes.data(), 1, bytes.size(), file));
  // Length of the record that begins at a place; 0: none does.
  const auto length_at = [&](size_t at) -> size_t {
    if (at + kRecordHeader > bytes.size()) return 0;
    const auto word = [&](size_t i) { return read_word(bytes.data() + at + 4 * i, swapped_); };
    const int64_t apart = int64_t{word(0)} - int64_t{first_second_};
    const uint32_t captured = word(2), length = word(3);
    const bool possible = std::abs(apart) < kMaxSeconds && word(1) < max_fraction_ &&
                          captured > 0 && captured <= length && length <= kMaxRecord;
    return possible ? kRecordHeader + captured : 0;
  };
  for (size_t at = 0; at < bytes.size(); ++at) {
    const size_t length = length_at(at);
    if (length == 0) continue;
    const bool last = at + length == bytes.size();
    if (!last && length_at(at + length) == 0) continue;
    const int64_t place = damaged + 1 + static_cast<int64_t>(at);
    if (fseeko(file, place, SEEK_SET) != 0) return std::nullopt;
    return place;
  }
  return std::nullopt;
}

}  // namespace infuse::recording
