#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/server/last_values.hpp"
#include "daemon/server/server_options.hpp"
#include "daemon/server/session.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Publishes reports to clients. Used on the one thread that runs the `io_context`, which outlives
/// it.
class Server {
 public:
  /// `release` and `session` are stated in the greeting.
  Server(boost::asio::io_context& io, const ServerOptions& options, std::string_view release,
         std::string_view session);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// States the configuration in the greeting of later clients.
  void set_configuration(const std::string& digest, const std::string& version);

  /// Listens on a Unix stream socket with access for its group. Replaces a socket on which nobody
  /// answers, and creates a missing folder.
  Result<void> listen(const std::filesystem::path& path);

  /// Uses a Unix stream socket that listens already (socket activation), and closes it at the end.
  Result<void> adopt(int listening_socket);

  /// Listens on the IPv4 loopback and returns the port; `port` 0 selects a free one.
  Result<uint16_t> listen_tcp(uint16_t port);

  /// Sends the report to every client that watches its class, and keeps it for `poll`. `device`:
  /// empty if the report is not of one device. `message`: a line without its line feed.
  void publish(ReportClass report_class, const std::string& device, Stamp stamp,
               std::string message);

  /// Sets the handler of requests that change the daemon. They are accepted from the daemon's own
  /// user and from root only (peer credentials); without a handler they are refused.
  void on_control(Session::Control control) { control_ = std::move(control); }

  /// Replaces the limits; connected clients keep theirs.
  void set_limits(const ServerOptions& options) { options_ = options; }

  /// Stops accepting and closes every session when its queue was sent, or after `timeout`.
  void finish(std::chrono::milliseconds timeout);

  /// Number of connected clients.
  size_t client_count() const { return sessions_.size(); }

 private:
  template <class Acceptor>
  void accept(Acceptor& acceptor);
  void open_session(Session::Socket socket);
  void reject(Session::Socket socket, const std::string& reason);
  std::shared_ptr<TokenBucket> requests_of(const ClientUser& client);
  void log_refusals();
  void check_sessions();
  void remove_closed();

  boost::asio::io_context& io_;
  ServerOptions options_;
  std::string release_, session_;
  Line greeting_;
  boost::asio::local::stream_protocol::acceptor local_;
  boost::asio::ip::tcp::acceptor tcp_;
  boost::asio::steady_timer timer_;
  std::filesystem::path path_;  // of the socket, if it is removed at the end
  LastValues last_values_;
  Session::Control control_ = [](const Request&) -> Result<std::string> {
    return fail("this daemon accepts no control requests");
  };
  std::vector<std::shared_ptr<Session>> sessions_;
  std::map<std::optional<uid_t>, std::shared_ptr<TokenBucket>> requests_;  // by user
  RefusalLog refusals_;
  std::vector<std::function<void()>> stalled_accepts_;  // retried by check_sessions
  std::optional<Session::Clock::time_point> finish_deadline_;
};

}  // namespace infuse::daemon
