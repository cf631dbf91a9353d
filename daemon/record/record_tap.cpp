#include "daemon/record/record_tap.hpp"

#include <algorithm>
#include <type_traits>

namespace infuse::daemon {
namespace {

template <class Plain>
std::span<const uint8_t> bytes_of(const Plain& value) {
  static_assert(std::is_trivially_copyable_v<Plain>);
  return {reinterpret_cast<const uint8_t*>(&value), sizeof(value)};
}

}  // namespace

void RecordTap::take(const Datagram& datagram) {
  const DatagramHead head{datagram.sender, datagram.sender_port, datagram.destination_port};
  put(RecordKind::kDatagram, 0, datagram.stamp, bytes_of(head), datagram.payload);
}

void RecordTap::take(const vehicle::CanFrame& frame) {
  put(RecordKind::kCanFrame, 0, frame.stamp, bytes_of(frame), {});
}

void RecordTap::take(size_t camera, const camera::StreamedPicture& picture) {
  const camera::RawPicture& raw = picture.raw;
  const PictureHead head{picture.sequence, raw.row_bytes, raw.width, raw.height, raw.format};
  put(RecordKind::kPicture, static_cast<uint32_t>(camera), picture.stamp, bytes_of(head),
      raw.bytes);
}

void RecordTap::take(const GpsFix& fix) { put(RecordKind::kFix, 0, fix.stamp, bytes_of(fix), {}); }

void RecordTap::look_after(Stamp now) {
  if (ring_.hand().bytes.empty()) {
    begun_ = now;
  } else if (now - begun_ >= kLongest) {
    hand_over();
    begun_ = now;
  }
}

void RecordTap::begin_chunk() {
  RecordChunk& chunk = ring_.hand();
  chunk.number = number_++;
  chunk.records_before = records_;
  chunk.first = RecordChunk::kNone;
  chunk.bytes.clear();
}

void RecordTap::hand_over() {
  ring_.hand().stamp = last_;
  ring_.publish();
  begin_chunk();
}

void RecordTap::put(RecordKind kind, uint32_t source, Stamp stamp, std::span<const uint8_t> head,
                    std::span<const uint8_t> body) {
  if (!wanted()) return;
  RecordChunk& chunk = ring_.hand();
  if (chunk.first == RecordChunk::kNone && chunk.bytes.size() < RecordChunk::kBytes) {
    chunk.first = chunk.bytes.size();
  }
  ++records_;
  last_ = stamp;
  append(bytes_of(RecordHeader{stamp.ns(), kind, source, head.size() + body.size()}));
  append(head);
  append(body);
}

// A chunk is handed over when it is full, so that the one in hand has room for a byte at least.
void RecordTap::append(std::span<const uint8_t> bytes) {
  while (!bytes.empty()) {
    std::vector<uint8_t>& chunk = ring_.hand().bytes;
    const size_t part = std::min(bytes.size(), RecordChunk::kBytes - chunk.size());
    chunk.insert(chunk.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(part));
    bytes = bytes.subspan(part);
    if (chunk.size() == RecordChunk::kBytes) hand_over();
  }
}

}  // namespace infuse::daemon
