#include "daemon/survey/capture_survey.hpp"

#include <algorithm>

#include "drivers/velodyne/packet.hpp"
#include "drivers/velodyne/position_packet.hpp"

namespace infuse::daemon {
namespace {

StreamKind kind_of(const Datagram& datagram) {
  if (datagram.payload.size() == velodyne::kPacketSize) return StreamKind::kData;
  if (datagram.payload.size() == velodyne::kPositionPacketSize) return StreamKind::kPosition;
  return StreamKind::kOther;
}

bool has_nmea_sentence(const Datagram& datagram) {
  const auto packet = velodyne::parse_position_packet(datagram.payload);
  return packet && packet->sentence.has_value();
}

}  // namespace

Stream* CaptureSurvey::stream_of(const Datagram& datagram) {
  const StreamKind kind = kind_of(datagram);
  const auto at = std::find_if(streams_.begin(), streams_.end(), [&](const Stream& stream) {
    return stream.sender == datagram.sender && stream.port == datagram.destination_port &&
           stream.kind == kind;
  });
  if (at != streams_.end()) return &*at;
  if (streams_.size() == kMaxStreams) return nullptr;
  Stream& stream = streams_.emplace_back();
  stream.sender = datagram.sender;
  stream.port = datagram.destination_port;
  stream.kind = kind;
  return &stream;
}

void CaptureSurvey::add(const Datagram& datagram) {
  Stream* stream = stream_of(datagram);
  if (stream == nullptr) {
    ++excess_datagrams_;
    return;
  }
  stream->arrivals.add(datagram.stamp);
  stream->bytes += datagram.payload.size();
  stream->last_size = static_cast<uint32_t>(datagram.payload.size());
  if (stream->kind == StreamKind::kData) stream->inference.add(datagram.payload);
  if (stream->kind == StreamKind::kPosition && has_nmea_sentence(datagram)) {
    ++stream->nmea_sentences;
  }
}

std::string CaptureSurvey::describe_unread() const {
  std::string text;
  const auto add = [&](uint64_t count, const char* what) {
    if (count == 0) return;
    text += (text.empty() ? "" : "; ") + std::to_string(count) + " packets " + what;
  };
  add(packets_.truncated, "cut short by the snapshot length (capture whole ones: tcpdump -s 0)");
  add(packets_.ipv6, "of IPv6, which is not read");
  add(packets_.malformed, "with contradictory lengths");
  add(packets_.not_udp, "that are not UDP");
  add(packets_.fragments_dropped, "that are fragments of incomplete datagrams");
  return text;
}

}  // namespace infuse::daemon
