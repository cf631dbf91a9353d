#include "drivers/recording/capture_reader.hpp"

#include <algorithm>
#include <cstdio>

#include "drivers/recording/capture_parts.hpp"

namespace infuse::recording {
namespace {

constexpr size_t kMaxNotes = 16;
constexpr Duration kMinNamedGap{50'000'000};     // half a sweep
constexpr Duration kMinNamedOverlap{1'000'000};  // stamps may be out of order by less

std::string seconds_text(Duration duration) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f s", to_seconds(duration));
  return text;
}

/// Stamp of a capture's first datagram, latest if there is none.
Result<Stamp> find_first_stamp(const std::filesystem::path& path) {
  auto reader = PcapReader::open(path);
  if (!reader) return tl::unexpected(reader.error());
  Datagram datagram;
  return reader->next(datagram) ? datagram.stamp : Stamp::latest();
}

void add(PcapCounters& sum, const PcapCounters& part) {
  sum.packets += part.packets;
  sum.datagrams += part.datagrams;
  sum.filtered += part.filtered;
  sum.ipv6 += part.ipv6;
  sum.not_udp += part.not_udp;
  sum.truncated += part.truncated;
  sum.malformed += part.malformed;
  sum.fragments += part.fragments;
  sum.fragments_dropped += part.fragments_dropped;
  sum.skipped_bytes += part.skipped_bytes;
}

}  // namespace

Result<CaptureReader> CaptureReader::open(const std::filesystem::path& path,
                                          const PcapOptions& options) {
  if (const auto wrong = options.invalid()) return fail(*wrong, "PcapOptions");
  const auto files = find_capture_parts(path);
  if (!files) return tl::unexpected(files.error());
  return open_parts(*files, options);
}

Result<CaptureReader> CaptureReader::open_parts(const std::vector<std::filesystem::path>& files,
                                                const PcapOptions& options) {
  CaptureReader reader;
  reader.options_ = options;
  for (const std::filesystem::path& file : files) {
    const auto first = find_first_stamp(file);
    if (first) {
      reader.parts_.push_back({file, *first});
    } else if (files.size() == 1) {
      return tl::unexpected(first.error());
    } else {
      reader.note(first.error().what, first.error().where, first.error().hint);
    }
  }
  if (reader.parts_.empty()) return tl::unexpected(reader.notes_.front());
  std::stable_sort(reader.parts_.begin(), reader.parts_.end(),
                   [](const Part& a, const Part& b) { return a.first < b.first; });
  reader.open_.reserve(kMaxOverlapping);
  return reader;
}

bool CaptureReader::next(Datagram& datagram) {
  if (current_ && !advance(open_[*current_])) close(*current_);
  const auto earlier = [](const OpenPart& a, const OpenPart& b) {
    return a.head.stamp < b.head.stamp;
  };
  auto first = std::min_element(open_.begin(), open_.end(), earlier);
  while (next_part_ < parts_.size() && open_.size() < kMaxOverlapping &&
         (open_.empty() || parts_[next_part_].first <= first->head.stamp)) {
    open_next_part();
    first = std::min_element(open_.begin(), open_.end(), earlier);
  }
  current_.reset();
  if (open_.empty()) return false;
  current_ = static_cast<size_t>(first - open_.begin());
  datagram = first->head;
  if (!end_ || datagram.stamp >= *end_) {
    end_ = datagram.stamp;
    end_part_ = first->index;
  }
  return true;
}

/// Opens the next part, and closes it again if nothing in it passes the filter.
void CaptureReader::open_next_part() {
  const size_t index = next_part_++;
  auto reader = PcapReader::open(parts_[index].path, options_);
  if (!reader) {  // it was readable before
    note(reader.error().what, reader.error().where, reader.error().hint);
    return;
  }
  OpenPart& part = open_.emplace_back(OpenPart{index, *std::move(reader), {}, Stamp::earliest()});
  if (!part.reader.next(part.head)) {
    close(open_.size() - 1);
    return;
  }
  part.last = part.head.stamp;
  note_gap(part);
}

bool CaptureReader::advance(OpenPart& part) {
  if (!part.reader.next(part.head)) return false;
  if (part.head.stamp > part.last) {
    longest_gap_ = std::max(longest_gap_, part.head.stamp - part.last);
    part.last = part.head.stamp;
  }
  return true;
}

void CaptureReader::close(size_t i) {
  std::vector<Error> more;
  open_[i].reader.append_notes(more);
  for (Error& error : more) note(error.what, error.where, error.hint);
  add(closed_, open_[i].reader.counters());
  note_overlaps(open_[i]);
  open_.erase(open_.begin() + static_cast<std::ptrdiff_t>(i));
}

void CaptureReader::note_gap(const OpenPart& next) {
  if (!end_ || open_.size() > 1) return;
  const Duration gap = next.head.stamp - *end_;
  if (gap <= std::max(kMinNamedGap, longest_gap_)) return;
  note(seconds_text(gap) + " are missing after " + parts_[end_part_].path.filename().string(),
       parts_[next.index].path.string(),
       "a part is missing, or the captures are not of one recording");
}

void CaptureReader::note_overlaps(const OpenPart& ended) {
  for (const OpenPart& other : open_) {
    if (other.index == ended.index) continue;
    const Duration overlap =
        ended.last - std::max(parts_[ended.index].first, parts_[other.index].first);
    if (overlap <= kMinNamedOverlap) continue;
    note(
        "overlaps " + parts_[other.index].path.filename().string() + " by " + seconds_text(overlap),
        parts_[ended.index].path.string(),
        "read together by time; name one file or a pattern if they are copies");
  }
}

void CaptureReader::note(std::string what, std::string where, std::string hint) {
  if (notes_.size() == kMaxNotes) {
    ++notes_left_out_;
    return;
  }
  notes_.push_back({std::move(what), std::move(where), std::move(hint)});
}

void CaptureReader::append_notes(std::vector<Error>& notes) const {
  notes.insert(notes.end(), notes_.begin(), notes_.end());
  for (const OpenPart& part : open_) part.reader.append_notes(notes);
  if (notes_left_out_ > 0) {
    notes.push_back({std::to_string(notes_left_out_) + " more problems of the captures",
                     parts_.front().path.string(), ""});
  }
}

PcapCounters CaptureReader::counters() const {
  PcapCounters sum = closed_;
  for (const OpenPart& part : open_) add(sum, part.reader.counters());
  return sum;
}

}  // namespace infuse::recording
