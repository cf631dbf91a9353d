#include "daemon/metrics/metrics_server.hpp"

#include <unistd.h>

#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_static_buffer.hpp>
#include <boost/beast/http.hpp>
#include <limits>
#include <optional>

#include "daemon/server/listening.hpp"

namespace infuse::daemon {
namespace {

namespace asio = boost::asio;
namespace http = boost::beast::http;
using ErrorCode = boost::system::error_code;
using Socket = asio::generic::stream_protocol::socket;

constexpr std::chrono::seconds kConnectionTimeout{1};  // of a connection from open to close
constexpr std::chrono::milliseconds kAcceptRetryDelay{200};
constexpr size_t kMaxHeaderBytes = 4096;  // bytes

/// Whether a Host header names this computer. A web page that had its name resolve to the loopback
/// (DNS rebinding) has another.
bool is_loopback_host(std::string_view host) {
  const size_t colon = host.find_last_of(':');
  if (colon != host.npos && host.find(']', colon) == host.npos) host = host.substr(0, colon);
  return host.empty() || host == "localhost" || host == "127.0.0.1" || host == "[::1]";
}

/// Connection with one request and its response. Lives as long as an operation is pending.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(Socket socket, std::shared_ptr<const std::string> text, std::shared_ptr<int> count)
      : over_tcp_(is_tcp(socket)),
        socket_(std::move(socket)),
        timer_(socket_.get_executor()),
        text_(std::move(text)),
        count_(std::move(count)) {
    ++*count_;
    parser_.header_limit(kMaxHeaderBytes);
    parser_.body_limit(std::numeric_limits<uint64_t>::max());  // a body is never read
  }
  ~Connection() { --*count_; }

  void start() {
    timer_.expires_after(kConnectionTimeout);
    timer_.async_wait([self = shared_from_this()](ErrorCode error) {
      if (!error) self->close();
    });
    http::async_read_header(socket_, buffer_, parser_,
                            [self = shared_from_this()](ErrorCode error, size_t) {
                              error ? self->refuse(error) : self->answer();
                            });
  }

 private:
  void refuse(ErrorCode error) {
    if (error == http::error::header_limit || error == http::error::buffer_overflow) {
      return send(http::status::request_header_fields_too_large, "request too long\n");
    }
    // Malformed HTTP is answered; a closed connection is not.
    if (error.category() == http::make_error_code(http::error::bad_version).category() &&
        error != http::error::end_of_stream && error != http::error::partial_message) {
      return send(http::status::bad_request, "invalid request: " + error.message() + "\n");
    }
    close();
  }

  void answer() {
    const auto& request = parser_.get();
    if (over_tcp_ && !is_loopback_host(std::string(request[http::field::host]))) {
      return send(http::status::misdirected_request, "not the host of these metrics\n");
    }
    const bool head = request.method() == http::verb::head;
    if (!head && request.method() != http::verb::get) {
      return send(http::status::method_not_allowed, "GET or HEAD\n");
    }
    const auto target = request.target().substr(0, request.target().find('?'));
    if (target != "/metrics") return send(http::status::not_found, "not found; see /metrics\n");
    send(http::status::ok, *text_, head);
  }

  void send(http::status status, const std::string& text, bool head = false) {
    response_.result(status);
    response_.set(http::field::content_type, status == http::status::ok
                                                 ? "text/plain; version=0.0.4; charset=utf-8"
                                                 : "text/plain");
    response_.keep_alive(false);
    response_.content_length(text.size());
    if (!head) response_.body() = text;
    serializer_.emplace(response_);
    http::async_write(socket_, *serializer_,
                      [self = shared_from_this()](ErrorCode, size_t) { self->close(); });
  }

  void close() {
    timer_.cancel();
    ErrorCode ignored;
    socket_.shutdown(asio::socket_base::shutdown_both, ignored);
    socket_.close(ignored);
  }

  static bool is_tcp(const Socket& socket) {
    ErrorCode error;
    const auto family = socket.local_endpoint(error).protocol().family();
    return !error && family != AF_UNIX;
  }

  bool over_tcp_;
  Socket socket_;
  asio::steady_timer timer_;
  std::shared_ptr<const std::string> text_;
  std::shared_ptr<int> count_;
  boost::beast::flat_static_buffer<kMaxHeaderBytes + 1> buffer_;
  http::request_parser<http::buffer_body> parser_;
  http::response<http::string_body> response_;
  std::optional<http::response_serializer<http::string_body>> serializer_;
};

}  // namespace

MetricsServer::MetricsServer(asio::io_context& io) : local_(io), tcp_(io), io_(io) {}

MetricsServer::~MetricsServer() {
  if (!path_.empty()) ::unlink(path_.c_str());
}

Result<void> MetricsServer::listen(const std::filesystem::path& path) {
  if (auto listening = listen_local(io_, local_, path); !listening) return listening;
  path_ = path;
  accept(local_);
  return {};
}

Result<uint16_t> MetricsServer::listen_tcp(uint16_t port) {
  return listen_loopback(tcp_, port).map([this](uint16_t taken) {
    accept(tcp_);
    return taken;
  });
}

Result<void> MetricsServer::listen(const MetricsSettings& settings) {
  if (!settings.path.empty()) {
    if (auto listening = listen(std::filesystem::path(settings.path)); !listening) {
      return listening;
    }
  }
  if (settings.port == 0) return {};
  return listen_tcp(settings.port).map([](uint16_t) {});
}

void MetricsServer::finish() {
  ErrorCode ignored;
  local_.close(ignored);
  tcp_.close(ignored);
}

// Connections beyond the maximum are closed at once. Without a free descriptor, accepting pauses.
template <class Acceptor>
void MetricsServer::accept(Acceptor& acceptor) {
  acceptor.async_accept([this, &acceptor](ErrorCode error, auto socket) {
    if (error == asio::error::operation_aborted || !acceptor.is_open()) return;
    if (!error) {
      if (*connections_ < kMaxConnections) {
        std::make_shared<Connection>(Socket(std::move(socket)), text_, connections_)->start();
      }
      return accept(acceptor);
    }
    const auto pause = std::make_shared<asio::steady_timer>(io_, kAcceptRetryDelay);
    pause->async_wait([this, &acceptor, pause](ErrorCode) {
      if (acceptor.is_open()) accept(acceptor);
    });
  });
}

}  // namespace infuse::daemon
