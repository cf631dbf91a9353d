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

void RecordTap::add_datagram(const Datagram& datagram) {
  const DatagramHeader header{datagram.sender, datagram.sender_port, datagram.destination_port};
  append_record(RecordKind::kDatagram, 0, datagram.stamp, bytes_of(header), datagram.payload);
}

void RecordTap::add_can_frame(const vehicle::CanFrame& frame) {
  append_record(RecordKind::kCanFrame, 0, frame.stamp, bytes_of(frame), {});
}

void RecordTap::add_image(size_t camera, const camera::StreamedImage& image) {
  const camera::RawImage& raw = image.raw;
  const ImageHeader header{image.sequence, raw.row_bytes, raw.width, raw.height, raw.format};
  append_record(RecordKind::kImage, static_cast<uint32_t>(camera), image.stamp, bytes_of(header),
                raw.bytes);
}

void RecordTap::add_gnss(const GnssFix& fix) {
  append_record(RecordKind::kGnssFix, 0, fix.stamp, bytes_of(fix), {});
}

void RecordTap::flush_if_due(Stamp now) {
  if (ring_.slot().bytes.empty()) {
    chunk_begun_ = now;
  } else if (now - chunk_begun_ >= kMaxChunkAge) {
    push_chunk();
    chunk_begun_ = now;
  }
}

void RecordTap::begin_chunk() {
  RecordChunk& chunk = ring_.slot();
  chunk.number = chunk_number_++;
  chunk.records_before = record_count_;
  chunk.first_record = RecordChunk::kNoRecord;
  chunk.bytes.clear();
}

void RecordTap::push_chunk() {
  ring_.slot().stamp = last_stamp_;
  ring_.publish();
  begin_chunk();
}

void RecordTap::append_record(RecordKind kind, uint32_t source, Stamp stamp,
                              std::span<const uint8_t> header, std::span<const uint8_t> body) {
  if (!enabled()) return;
  RecordChunk& chunk = ring_.slot();
  if (chunk.first_record == RecordChunk::kNoRecord && chunk.bytes.size() < RecordChunk::kMaxBytes) {
    chunk.first_record = chunk.bytes.size();
  }
  ++record_count_;
  last_stamp_ = stamp;
  append_bytes(bytes_of(RecordHeader{stamp.ns(), kind, source, header.size() + body.size()}));
  append_bytes(header);
  append_bytes(body);
}

// A full chunk is handed over at once, so that the current one always has room for at least one
// byte.
void RecordTap::append_bytes(std::span<const uint8_t> bytes) {
  while (!bytes.empty()) {
    std::vector<uint8_t>& chunk = ring_.slot().bytes;
    const size_t part = std::min(bytes.size(), RecordChunk::kMaxBytes - chunk.size());
    chunk.insert(chunk.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(part));
    bytes = bytes.subspan(part);
    if (chunk.size() == RecordChunk::kMaxBytes) push_chunk();
  }
}

}  // namespace infuse::daemon
