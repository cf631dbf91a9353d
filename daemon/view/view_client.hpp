#pragma once

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <deque>
#include <functional>
#include <memory>
#include <string>

#include "daemon/view/view_stream.hpp"

namespace infuse::daemon {

/// A message for pages, shared by all that get it.
struct ViewMessage {
  std::string data;
  /// Of a binary message, "sweep:0" …: of those with one key only the newest is of use. Empty:
  /// text.
  std::string key{};

  bool binary() const { return !key.empty(); }
};

/// One open page: a WebSocket with a queue of bounded size.
class ViewClient : public std::enable_shared_from_this<ViewClient> {
 public:
  using Message = std::shared_ptr<const ViewMessage>;
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;

  /// `on_open` is called after the handshake, `on_command` with each text that the page sends,
  /// `on_end` once.
  struct Handlers {
    std::function<void(const std::shared_ptr<ViewClient>&)> on_open;
    std::function<void(const std::shared_ptr<ViewClient>&, const std::string&)> on_command;
    std::function<void(const std::shared_ptr<ViewClient>&)> on_end;
  };

  ViewClient(ViewStream&& stream, Handlers handlers);

  /// Answers the request for a WebSocket.
  void accept(Request request);

  /// Queues a message; a binary one in place of one with its key that waits. A page that does not
  /// keep up loses messages, and gets their number when it reads again.
  void send(const Message& message);

  void close();

  /// Whether the page shows dependence profiles; false at first.
  bool profiles_wanted() const { return profiles_wanted_; }
  void set_profiles_wanted(bool wanted) { profiles_wanted_ = wanted; }

 private:
  void read();
  void write();
  void end();

  boost::beast::websocket::stream<ViewStream, false> socket_;  // no compression
  Handlers handlers_;
  Request request_;
  boost::beast::flat_buffer buffer_;
  std::deque<Message> queue_;
  uint64_t lost_ = 0;
  bool profiles_wanted_ = false;
  bool writing_ = false;
  bool open_ = false;  // after the handshake
  bool ended_ = false;
};

}  // namespace infuse::daemon
