#pragma once

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "daemon/view/foxglove_protocol.hpp"
#include "daemon/view/view_stream.hpp"
#include "daemon/view/viewer_channels.hpp"

namespace infuse::daemon {

/// A viewer that speaks Foxglove's protocol: a WebSocket with subscriptions and a queue of bounded
/// size. Runs on the view's thread.
class ViewerClient : public std::enable_shared_from_this<ViewerClient> {
 public:
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;

  /// `channels` outlives this. `on_end` is called once. `session`: of this run.
  ViewerClient(ViewStream&& stream, ViewerChannels& channels, std::string session,
               std::function<void(const std::shared_ptr<ViewerClient>&)> on_end);

  /// Answers the request for a WebSocket of this subprotocol.
  void accept(Request request, std::string_view subprotocol);

  /// Queues a message for its subscriptions. A viewer that does not keep up loses it, and receives
  /// the number when it reads again. `dropped`: messages that were lost before they came here.
  void send(const ViewerChannels::Message& message, uint64_t dropped);

  void close();

 private:
  struct Queued {
    std::string data;
    bool binary = true;
  };
  void read();
  void handle(const std::string& text);
  void subscribe(const ViewerRequest::Subscription& subscription);
  void send_text(std::string text);
  void send_to(uint32_t subscription, const ViewerMessage& message);
  void enqueue(Queued queued);
  void write();
  void end();

  boost::beast::websocket::stream<ViewStream, false> socket_;  // no compression
  ViewerChannels& channels_;
  const std::string session_;
  std::function<void(const std::shared_ptr<ViewerClient>&)> on_end_;
  Request request_;
  boost::beast::flat_buffer buffer_;
  std::map<uint32_t, uint32_t> subscriptions_;  // channel by subscription
  std::deque<Queued> queue_;
  size_t queued_bytes_ = 0;
  uint64_t lost_ = 0;
  Stamp time_;  // of a replay, as sent
  bool writing_ = false;
  bool open_ = false;  // after the handshake
  bool ended_ = false;
};

}  // namespace infuse::daemon
