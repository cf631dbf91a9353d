#include "drivers/makers/capture_survey.hpp"

#include <algorithm>

#include "drivers/makers/makers.hpp"

namespace infuse::makers {

Stream* CaptureSurvey::stream_of(const Datagram& datagram) {
  const lidar::ClassifiedPacket packet = classify(datagram.payload);
  const auto at = std::find_if(streams_.begin(), streams_.end(), [&](const Stream& stream) {
    return stream.sender == datagram.sender && stream.port == datagram.destination_port &&
           stream.maker == packet.maker && stream.packet_class == packet.packet_class;
  });
  if (at != streams_.end()) return &*at;
  if (streams_.size() == kMaxStreams) return nullptr;
  Stream& stream = streams_.emplace_back();
  stream.sender = datagram.sender;
  stream.port = datagram.destination_port;
  stream.maker = packet.maker;
  stream.packet_class = packet.packet_class;
  if (stream.has_data()) stream.inference = packet.maker->make_inference();
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
  if (stream->inference != nullptr) stream->inference->add(datagram.payload);
  if (stream->packet_class != lidar::PacketClass::kInformation) return;
  if (stream->statement.empty()) stream->statement = stream->maker->describe(datagram.payload);
  stream->fixes += stream->maker->read_fix(datagram) ? 1 : 0;
}

std::string CaptureSurvey::describe_unread() const {
  std::string text;
  const auto add = [&](uint64_t count, const char* what) {
    if (count == 0) return;
    text += (text.empty() ? "" : "; ") + std::to_string(count) + " packets " + what;
  };
  add(packets_.truncated, "cut short by the snapshot length (capture whole ones: tcpdump -s 0)");
  add(packets_.ipv6, "of IPv6 that are not UDP");
  add(packets_.malformed, "with contradictory lengths");
  add(packets_.not_udp, "that are not UDP");
  add(packets_.fragments_dropped, "that are fragments of incomplete datagrams");
  return text;
}

}  // namespace infuse::makers
