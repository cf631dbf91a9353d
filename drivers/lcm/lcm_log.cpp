#include "drivers/lcm/lcm_log.hpp"

#include <algorithm>
#include <array>

namespace infuse::lcm {
namespace {

constexpr std::array<uint8_t, 4> kSyncWord = {0xED, 0xA1, 0xDA, 0x01};
constexpr size_t kEventHeader = 28;
constexpr uint32_t kMaxChannelBytes = 999;  // as liblcm; its own channels have at most 63
constexpr uint64_t kMaxEventUs = 9'000'000'000'000'000;  // in ns it still fits 64 bits
constexpr size_t kSearchBytes = size_t{16} << 20;

template <class Number>
Number read_number(std::span<const uint8_t> bytes, size_t at) {
  Number value = 0;
  for (size_t k = 0; k < sizeof value; ++k) value = static_cast<Number>(value << 8 | bytes[at + k]);
  return value;
}

bool has_sync(std::span<const uint8_t> bytes, size_t at) {
  return bytes.size() - at >= kSyncWord.size() &&
         std::equal(kSyncWord.begin(), kSyncWord.end(),
                    bytes.begin() + static_cast<std::ptrdiff_t>(at));
}

/// Size of the event at a position; nothing if there is none, or it is cut.
std::optional<size_t> event_size(std::span<const uint8_t> bytes, size_t at) {
  if (bytes.size() - at < kEventHeader || !has_sync(bytes, at)) return std::nullopt;
  const size_t room = bytes.size() - at - kEventHeader;
  const auto channel = read_number<uint32_t>(bytes, at + 20);
  const size_t data = read_number<uint32_t>(bytes, at + 24);
  if (read_number<uint64_t>(bytes, at + 12) > kMaxEventUs) return std::nullopt;
  if (channel == 0 || channel > kMaxChannelBytes || channel + data > room) return std::nullopt;
  const auto name = bytes.subspan(at + kEventHeader, channel);
  const auto is_printable = [](uint8_t c) { return c >= 0x20 && c < 0x7F; };
  if (!std::ranges::all_of(name, is_printable)) return std::nullopt;
  return kEventHeader + channel + data;
}

/// True if an event may end here: at another one, or at the end of the file.
bool may_end(std::span<const uint8_t> bytes, size_t at) {
  return at == bytes.size() || has_sync(bytes, at);
}

/// First position in [`from`, `to`) of an event that is followed by another one or by the end.
std::optional<size_t> find_event(std::span<const uint8_t> bytes, size_t from, size_t to) {
  const auto end = bytes.begin() +
                   static_cast<std::ptrdiff_t>(std::min(to + kSyncWord.size() - 1, bytes.size()));
  auto at = bytes.begin() + static_cast<std::ptrdiff_t>(std::min(from, bytes.size()));
  while (at < end) {
    at = std::search(at, end, kSyncWord.begin(), kSyncWord.end());
    if (at == end) break;
    const auto position = static_cast<size_t>(at - bytes.begin());
    const auto size = event_size(bytes, position);
    if (size && may_end(bytes, position + *size)) return position;
    ++at;
  }
  return std::nullopt;
}

}  // namespace

Result<LcmReader> LcmReader::open(std::span<const uint8_t> bytes, const std::string& name) {
  LcmReader reader(bytes, name);
  // A single event that is cut behind is a log as well.
  if (!event_size(bytes, 0) && !find_event(bytes, 0, std::min(bytes.size(), kSearchBytes)))
    return fail("is not a log of LCM", name, "no event is found");
  return reader;
}

void LcmReader::skip_to(size_t position) {
  if (counters_.damaged_places++ == 0) first_damage_ = position_;
  counters_.skipped_bytes += position - position_;
  position_ = position;
  after_damage_ = true;
}

bool LcmReader::next(LcmEvent& event) {
  while (position_ < bytes_.size()) {
    const auto size = event_size(bytes_, position_);
    const size_t end = size ? position_ + *size : position_;
    // An event that does not end where the next one begins: either its own length is damaged, and
    // then there is an event within it, or the next one is.
    if (!size || !may_end(bytes_, end)) {
      const auto other = find_event(bytes_, position_ + 1, size ? end : bytes_.size());
      if (other || !size) {
        is_cut_ = !other && has_sync(bytes_, position_);
        skip_to(other.value_or(bytes_.size()));
        continue;
      }
    }
    const size_t channel = read_number<uint32_t>(bytes_, position_ + 20);
    const auto name = bytes_.subspan(position_ + kEventHeader, channel);
    event.number = read_number<uint64_t>(bytes_, position_ + 4);
    event.time =
        Stamp::from_ns(static_cast<int64_t>(read_number<uint64_t>(bytes_, position_ + 12)) * 1000);
    event.channel = {reinterpret_cast<const char*>(name.data()), name.size()};
    event.data = bytes_.subspan(position_ + kEventHeader + channel, *size - kEventHeader - channel);
    constexpr uint64_t kMaxMissing = 1'000'000'000;  // more: the numbers are of another log
    if (after_damage_ && last_number_ && event.number > *last_number_ &&
        event.number - *last_number_ <= kMaxMissing)
      counters_.missing_events += event.number - *last_number_ - 1;
    last_number_ = event.number;
    after_damage_ = false;
    position_ = end;
    ++counters_.events;
    return true;
  }
  return false;
}

void LcmReader::append_notes(std::vector<Error>& notes) const {
  if (counters_.damaged_places == 0) return;
  if (counters_.damaged_places == 1 && is_cut_) {
    notes.push_back({"ends within an event, at byte " + std::to_string(first_damage_), name_,
                     "the events before it are read"});
    return;
  }
  std::string missing;
  if (counters_.missing_events > 0)
    missing = ", with " + std::to_string(counters_.missing_events) + " events by their numbers";
  notes.push_back({std::to_string(counters_.skipped_bytes) + " bytes are skipped at " +
                       std::to_string(counters_.damaged_places) + " damaged places" + missing +
                       "; the first is at byte " + std::to_string(first_damage_),
                   name_, ""});
}

}  // namespace infuse::lcm
