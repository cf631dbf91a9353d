#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <string_view>

#include "daemon/config/view_settings.hpp"
#include "daemon/view/view_stream.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Takes the view's connections, checks who may ask for what, answers requests for the page's
/// files, and hands on connections that become WebSockets. On the thread of the `io_context`.
class ViewRequests {
 public:
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;

  struct Handlers {
    std::function<size_t()> open;  ///< number of pages and viewers
    std::function<void(ViewStream, Request)> on_page;
    /// With the protocol that was chosen; null: there are no viewers.
    std::function<void(ViewStream, Request, std::string_view)> on_viewer;
  };

  /// The settings outlive this.
  ViewRequests(boost::asio::io_context& io, const ViewSettings& settings, Handlers handlers);

  /// Errors: an address cannot be bound.
  Result<void> listen();

  /// Takes no more connections.
  void close();

  /// Port that was bound; 0: none.
  uint16_t port() const { return port_; }

  /// Address of the page, without its token.
  std::string address() const;

 private:
  struct Connection;
  using Shared = std::shared_ptr<Connection>;

  Result<void> listen_tcp();
  template <class Acceptor>
  void accept(Acceptor& acceptor);
  void make_room();
  void serve(const Shared& connection);
  void handle(const Shared& connection);
  void answer(const Shared& connection, int status, std::string_view type, std::string_view body);

  const ViewSettings& settings_;
  const Handlers handlers_;
  boost::asio::io_context& io_;
  boost::asio::ip::tcp::acceptor acceptor_{io_};
  boost::asio::local::stream_protocol::acceptor local_{io_};
  uint16_t port_ = 0;
  size_t connections_ = 0;
  std::list<std::weak_ptr<Connection>> silent_;  // have not asked yet, the oldest first
};

}  // namespace infuse::daemon
