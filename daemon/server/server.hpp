#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/server/last_values.hpp"
#include "daemon/server/server_options.hpp"
#include "daemon/server/session.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Tells whoever listens. Used on the one thread that runs the `io_context`, which outlives it.
class Server {
 public:
  /// `release` and `session` go into the greeting.
  Server(boost::asio::io_context& io, const ServerOptions& options, std::string_view release,
         std::string_view session);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// Listens on a Unix stream socket that its group may use. A socket that nobody answers on is
  /// taken over; the folder is made where it is missing.
  Result<void> listen(const std::filesystem::path& path);

  /// Takes over a Unix stream socket that somebody else listens on for the daemon, and closes it in
  /// the end.
  Result<void> adopt(int listening_socket);

  /// Listens on the IPv4 loopback; `port` 0 takes a free one. Gives the port.
  Result<uint16_t> listen_tcp(uint16_t port);

  /// Sends the report to every client that watches its class, and keeps it for `poll`. `device` is
  /// empty where the report is not of one sensor; `message` is a line without its line feed.
  void publish(ReportClass report_class, const std::string& device, Stamp stamp,
               std::string message);

  /// Who carries out the requests that change the daemon. They are taken from the daemon's own user
  /// and from root only, as the kernel names them; without a handler they are refused.
  void on_control(Session::Control control) { control_ = std::move(control); }

  /// Clients are held to these limits from now on; those that are connected keep their queue.
  void set_limits(const ServerOptions& options) { options_ = options; }

  /// Accepts nobody any more and lets every client go: when it has read what it is owed, or after
  /// `patience`.
  void finish(std::chrono::milliseconds timeout);

  /// Connections at present.
  size_t client_count() const { return sessions_.size(); }

 private:
  template <class Acceptor>
  void accept(Acceptor& acceptor);
  void open_session(Session::Socket socket);
  void reject(Session::Socket socket);
  void check_sessions();
  void remove_closed();

  boost::asio::io_context& io_;
  ServerOptions options_;
  Line greeting_;
  boost::asio::local::stream_protocol::acceptor local_;
  boost::asio::ip::tcp::acceptor tcp_;
  boost::asio::steady_timer timer_;
  std::filesystem::path path_;  // of the socket, while it is ours to remove
  LastValues last_values_;
  Session::Control control_ = [](const Request&) -> Result<void> {
    return fail("there is nothing that could be changed");
  };
  std::vector<std::shared_ptr<Session>> sessions_;
  std::vector<std::function<void()>> stalled_accepts_;  // acceptors to be started again
  std::optional<Session::Clock::time_point> finish_deadline_;
};

}  // namespace infuse::daemon
