#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <chrono>
#include <filesystem>
#include <memory>
#include <string>

#include "daemon/config/metrics_settings.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Serves GET /metrics over HTTP, on a Unix socket or the loopback. One response per connection;
/// number, duration and request size of connections are bounded. Used on the one thread that runs
/// the `io_context`, which outlives it.
class MetricsServer {
 public:
  explicit MetricsServer(boost::asio::io_context& io);
  ~MetricsServer();
  MetricsServer(const MetricsServer&) = delete;
  MetricsServer& operator=(const MetricsServer&) = delete;

  /// Listens on a Unix stream socket with access for its group.
  Result<void> listen(const std::filesystem::path& path);

  /// Listens on the IPv4 loopback and returns the port; `port` 0 selects a free one.
  Result<uint16_t> listen_tcp(uint16_t port);

  /// Listens at the configured endpoints.
  Result<void> listen(const MetricsSettings& settings);

  /// Sets the body of the response.
  void set_text(std::string text) { *text_ = std::move(text); }

  /// Stops accepting; open connections are still served.
  void finish();

 private:
  static constexpr int kMaxConnections = 16;

  template <class Acceptor>
  void accept(Acceptor& acceptor);

  boost::asio::local::stream_protocol::acceptor local_;
  boost::asio::ip::tcp::acceptor tcp_;
  boost::asio::io_context& io_;
  std::filesystem::path path_;  // of the socket, if it is removed at the end
  // Shared with connections, which may outlive this object.
  std::shared_ptr<std::string> text_ = std::make_shared<std::string>();
  std::shared_ptr<int> connections_ = std::make_shared<int>(0);
};

}  // namespace infuse::daemon
