#include "daemon/view/view_requests.hpp"

#include <algorithm>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>

#include "daemon/server/listening.hpp"
#include "daemon/view/access.hpp"
#include "daemon/view/view_files.hpp"
#include "daemon/view/viewer_client.hpp"

namespace infuse::daemon {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;

constexpr size_t kMaxConnections = 32;  // number of them, pages and requests
constexpr uint32_t kMaxHeaderBytes = 8192;
constexpr std::chrono::seconds kRequestTime{10};
constexpr const char* kFull = "as many pages and viewers are open as max_clients";

std::string_view type_of(std::string_view file) {
  if (file.ends_with(".html")) return "text/html; charset=utf-8";
  if (file.ends_with(".svg")) return "image/svg+xml";
  return file.ends_with(".css") ? "text/css; charset=utf-8" : "text/javascript; charset=utf-8";
}

/// The file at a path of the page's address, or null; the page itself is at "/".
const ViewFile* find_file(std::string_view path) {
  for (const ViewFile& file : view_files()) {
    if (path == "/" ? file.name == "view.html" : path.substr(1) == file.name) return &file;
  }
  return nullptr;
}

std::string_view text_of(beast::string_view text) { return {text.data(), text.size()}; }

using Response = http::response<http::string_body>;

Response respond(unsigned version, int status, std::string_view type, std::string_view body) {
  Response response(static_cast<http::status>(status), version);
  response.set(http::field::content_type, {type.data(), type.size()});
  response.set(http::field::cache_control, "no-store");
  response.set("Content-Security-Policy",
               "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; "
               "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Referrer-Policy", "no-referrer");
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  response.body() = std::string(body);
  response.prepare_payload();
  response.keep_alive(false);
  return response;
}

}  // namespace

/// A connection before it is a page: one request.
struct ViewRequests::Connection : std::enable_shared_from_this<Connection> {
  explicit Connection(ViewStream::socket_type socket) : stream(std::move(socket)) {
    parser.header_limit(kMaxHeaderBytes);
    parser.body_limit(0);
  }
  ViewStream stream;
  beast::flat_buffer buffer{kMaxHeaderBytes};
  http::request_parser<http::empty_body> parser;
  Response response;
};

ViewRequests::ViewRequests(asio::io_context& io, const ViewSettings& settings, Handlers handlers)
    : settings_(settings), handlers_(std::move(handlers)), io_(io) {}

Result<void> ViewRequests::listen() {
  if (settings_.port != 0 || settings_.path.empty()) {
    if (auto listening = listen_tcp(); !listening) return listening;
    accept(acceptor_);
  }
  if (!settings_.path.empty()) {
    if (auto listening = listen_local(io_, local_, settings_.path); !listening) return listening;
    accept(local_);
  }
  return {};
}

void ViewRequests::close() {
  acceptor_.close();
  local_.close();
}

Result<void> ViewRequests::listen_tcp() {
  beast::error_code error;
  const tcp::endpoint endpoint(asio::ip::make_address(settings_.bind), settings_.port);
  acceptor_.open(endpoint.protocol(), error);
  if (!error) acceptor_.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) acceptor_.bind(endpoint, error);
  if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
  if (error) {
    return fail("the view: " + error.message(),
                settings_.bind + ":" + std::to_string(settings_.port), "another port in [view]");
  }
  port_ = acceptor_.local_endpoint().port();
  return {};
}

std::string ViewRequests::address() const {
  if (settings_.port == 0 && !settings_.path.empty()) return settings_.path;
  const bool v6 = settings_.bind.find(':') != std::string::npos;
  const std::string socket = settings_.path.empty() ? "" : " and " + settings_.path;
  return "http://" + (v6 ? "[" + settings_.bind + "]" : settings_.bind) + ":" +
         std::to_string(port_) + "/" + socket;
}

template <class Acceptor>
void ViewRequests::accept(Acceptor& acceptor) {
  acceptor.async_accept([this, &acceptor](beast::error_code error, auto socket) {
    if (!acceptor.is_open()) return;
    if (!error) serve(std::make_shared<Connection>(std::move(socket)));
    accept(acceptor);
  });
}

/// Who connects and asks nothing gives way to who comes later.
void ViewRequests::make_room() {
  if (connections_ + handlers_.open() < kMaxConnections) return;
  while (!silent_.empty()) {
    const auto oldest = silent_.front().lock();
    silent_.pop_front();
    if (!oldest) continue;
    beast::error_code ignored;
    oldest->stream.socket().close(ignored);
    return;
  }
}

void ViewRequests::serve(const Shared& connection) {
  std::erase_if(silent_, [](const auto& one) { return one.expired(); });
  make_room();
  ++connections_;
  silent_.push_back(connection);
  connection->stream.expires_after(kRequestTime);
  http::async_read(connection->stream, connection->buffer, connection->parser,
                   [this, connection](beast::error_code error, size_t) {
                     --connections_;
                     std::erase_if(silent_, [&](const auto& one) {
                       return one.expired() || one.lock() == connection;
                     });
                     if (!error) handle(connection);
                   });
}

void ViewRequests::handle(const Shared& connection) {
  const auto& request = connection->parser.get();
  const auto text = [&](http::field field) { return text_of(request[field]); };
  const bool upgrade = beast::websocket::is_upgrade(request);
  const ViewRequest view{.method = text_of(request.method_string()),
                         .target = text_of(request.target()),
                         .host = text(http::field::host),
                         .origin = text(http::field::origin),
                         .cookie = text(http::field::cookie),
                         .hosts = static_cast<int>(request.count(http::field::host)),
                         .upgrade = upgrade};
  if (const auto refused = check_access(view, settings_)) {
    return answer(connection, refused->status, "text/plain", refused->reason);
  }
  const std::string_view path = path_of(view.target);
  const bool full = handlers_.open() >= settings_.max_clients;
  const std::string_view protocol =
      upgrade && handlers_.on_viewer ? choose_subprotocol(text(http::field::sec_websocket_protocol))
                                     : std::string_view{};
  if (!protocol.empty() && (path == "/" || path == "/foxglove")) {
    if (full) return answer(connection, 503, "text/plain", kFull);
    return handlers_.on_viewer(std::move(connection->stream), connection->parser.release(),
                               protocol);
  }
  if (path == "/stream") {
    if (!upgrade) return answer(connection, 426, "text/plain", "a WebSocket");
    if (full) return answer(connection, 503, "text/plain", kFull);
    return handlers_.on_page(std::move(connection->stream), connection->parser.release());
  }
  const ViewFile* file = find_file(path);
  if (file == nullptr) return answer(connection, 404, "text/plain", "no such page");
  answer(connection, 200, type_of(file->name), file->text);
}

void ViewRequests::answer(const Shared& connection, int status, std::string_view type,
                          std::string_view body) {
  const auto& request = connection->parser.get();
  connection->response = respond(request.version(), status, type, body);
  if (request.method() == http::verb::head) connection->response.body().clear();
  if (status == 200 && !settings_.token.empty()) {
    connection->response.set(
        http::field::set_cookie,
        std::string(kTokenCookie) + "=" + settings_.token + "; HttpOnly; SameSite=Strict; Path=/");
  }
  connection->stream.expires_after(kRequestTime);
  ++connections_;
  http::async_write(
      connection->stream, connection->response, [this, connection](beast::error_code, size_t) {
        --connections_;
        beast::error_code ignored;
        connection->stream.socket().shutdown(asio::socket_base::shutdown_send, ignored);
      });
}

}  // namespace infuse::daemon
