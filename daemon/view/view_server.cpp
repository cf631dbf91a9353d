#include "daemon/view/view_server.hpp"

#include <pthread.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <list>
#include <map>
#include <set>
#include <thread>

#include "daemon/process/crash_note.hpp"
#include "daemon/protocol/json.hpp"
#include "daemon/server/listening.hpp"
#include "daemon/view/access.hpp"
#include "daemon/view/report_store.hpp"
#include "daemon/view/view_client.hpp"
#include "daemon/view/view_files.hpp"
#include "daemon/view/view_frames.hpp"
#include "daemon/view/view_profiler.hpp"
#include "daemon/view/viewer_client.hpp"
#include "drivers/camera/jpeg_encoder.hpp"

namespace infuse::daemon {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;

constexpr size_t kMaxConnections = 32;  // number of them, pages and requests
constexpr size_t kMaxPending = 512;     // reports that this thread has not read yet
constexpr uint32_t kMaxHeaderBytes = 8192;
constexpr std::chrono::seconds kRequestTime{10};
constexpr std::chrono::milliseconds kFramePeriod{50};
constexpr std::chrono::seconds kProfilePeriod{2};  // of each camera; a profile takes 50 ms
constexpr int kJpegQuality = 75;
constexpr double kMapStep = 40;                         // m
constexpr size_t kMaxViewerPending = size_t{32} << 20;  // bytes of messages on their way here
constexpr size_t kMaxStoredReports = size_t{4} << 20;   // bytes of reports for pages opened later
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

/// Of the frames of a lidar or camera (see `ViewMessage::key`).
std::string key_of(const char* kind, size_t index) {
  return std::string(kind) + ":" + std::to_string(index);
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

/// The thread and what runs on it.
class ViewServer::Impl {
 public:
  Impl(const ViewSettings& settings, const Rig& rig, const streetmap::SegmentMap* map, ViewTap& tap,
       ReplayControl control, ViewerChannels* channels)
      : settings_(settings),
        rig_(rig),
        map_(map),
        tap_(tap),
        control_(std::move(control)),
        channels_(channels),
        profiler_(rig),
        next_profile_(rig.cameras.size()) {
    if (channels_ == nullptr) return;
    channels_->on_message([this](ViewerChannels::Message message) { pass_on(std::move(message)); });
  }

  ~Impl() {
    asio::post(io_, [this] {
      acceptor_.close();
      local_.close();
      for (const auto& client : clients_) client->close();
      for (const auto& viewer : viewers_) viewer->close();
      io_.stop();
    });
    if (thread_.joinable()) thread_.join();
    tap_.set_wanted(false);
    if (!settings_.path.empty()) ::unlink(settings_.path.c_str());
  }

  Result<void> listen() {
    if (settings_.port != 0 || settings_.path.empty()) {
      if (auto listening = listen_tcp(); !listening) return listening;
      accept(acceptor_);
    }
    if (!settings_.path.empty()) {
      if (auto listening = listen_local(io_, local_, settings_.path); !listening) return listening;
      accept(local_);
    }
    thread_ = std::thread([this] {
      pthread_setname_np(pthread_self(), "view");
      use_crash_stack();
      io_.run();
    });
    return {};
  }

  Result<void> listen_tcp() {
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

  uint16_t port() const { return port_; }
  const ViewSettings& settings() const { return settings_; }
  size_t clients() const { return client_count_.load(); }

  void publish(ReportClass report_class, const std::string& line) {
    const bool kept = ReportStore::wants(report_class);
    if (client_count_.load() == 0 && !kept) return;
    if (pending_.fetch_add(1) >= kMaxPending) {
      pending_.fetch_sub(1);
      return;
    }
    asio::post(io_, [this, kept, report_class,
                     message = std::make_shared<const ViewMessage>(ViewMessage{line})] {
      pending_.fetch_sub(1);
      if (kept) reports_.add(report_class, message->data);
      for (const auto& client : clients_) client->send(message);
    });
  }

  void end_drive() {
    asio::post(io_, [this] {
      ended_ = std::make_shared<const ViewMessage>(ViewMessage{json_text({{"class", "END"}})});
      for (const auto& client : clients_) client->send(ended_);
    });
  }

 private:
  /// A connection before it is a page: one request.
  struct Connection : std::enable_shared_from_this<Connection> {
    explicit Connection(ViewStream::socket_type socket) : stream(std::move(socket)) {
      parser.header_limit(kMaxHeaderBytes);
      parser.body_limit(0);
    }
    ViewStream stream;
    beast::flat_buffer buffer{kMaxHeaderBytes};
    http::request_parser<http::empty_body> parser;
    Response response;
  };

  template <class Acceptor>
  void accept(Acceptor& acceptor) {
    acceptor.async_accept([this, &acceptor](beast::error_code error, auto socket) {
      if (!acceptor.is_open()) return;
      if (!error) serve(std::make_shared<Connection>(std::move(socket)));
      accept(acceptor);
    });
  }

  /// Who connects and asks nothing gives way to who comes later.
  void make_room() {
    if (connections_ + clients_.size() + viewers_.size() < kMaxConnections) return;
    while (!silent_.empty()) {
      const auto oldest = silent_.front().lock();
      silent_.pop_front();
      if (!oldest) continue;
      beast::error_code ignored;
      oldest->stream.socket().close(ignored);
      return;
    }
  }

  void serve(const std::shared_ptr<Connection>& connection) {
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

  void handle(const std::shared_ptr<Connection>& connection) {
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
    const std::string_view protocol =
        upgrade && channels_ != nullptr
            ? choose_subprotocol(text(http::field::sec_websocket_protocol))
            : std::string_view{};
    if (!protocol.empty() && (path == "/" || path == "/foxglove")) {
      if (is_full()) return answer(connection, 503, "text/plain", kFull);
      return open_viewer(connection, protocol);
    }
    if (path == "/stream") {
      if (!upgrade) return answer(connection, 426, "text/plain", "a WebSocket");
      if (is_full()) return answer(connection, 503, "text/plain", kFull);
      return open_page(connection);
    }
    const ViewFile* file = find_file(path);
    if (file == nullptr) return answer(connection, 404, "text/plain", "no such page");
    answer(connection, 200, type_of(file->name), file->text);
  }

  void answer(const std::shared_ptr<Connection>& connection, int status, std::string_view type,
              std::string_view body) {
    const auto& request = connection->parser.get();
    connection->response = respond(request.version(), status, type, body);
    if (request.method() == http::verb::head) connection->response.body().clear();
    if (status == 200 && !settings_.token.empty()) {
      connection->response.set(http::field::set_cookie, std::string(kTokenCookie) + "=" +
                                                            settings_.token +
                                                            "; HttpOnly; SameSite=Strict; Path=/");
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

  void open_page(const std::shared_ptr<Connection>& connection) {
    const auto client = std::make_shared<ViewClient>(
        std::move(connection->stream),
        ViewClient::Handlers{
            .on_open = [this](const auto& opened) { greet(*opened); },
            .on_command = [this](const auto& from, const auto& text) { command(*from, text); },
            .on_end = [this](const auto& ended) { remove(ended); }});
    clients_.insert(client);
    client_count_ = clients_.size();
    tap_.set_wanted(true);
    if (control_) control_({.kind = ViewCommand::Kind::kOpened});
    if (clients_.size() == 1) poll();
    client->accept(connection->parser.release());
  }

  bool is_full() const { return clients_.size() + viewers_.size() >= settings_.max_clients; }

  void open_viewer(const std::shared_ptr<Connection>& connection, std::string_view protocol) {
    const auto viewer =
        std::make_shared<ViewerClient>(std::move(connection->stream), *channels_, session_,
                                       [this](const auto& ended) { viewers_.erase(ended); });
    viewers_.insert(viewer);
    if (control_) control_({.kind = ViewCommand::Kind::kOpened});
    viewer->accept(connection->parser.release(), protocol);
  }

  /// Passes a message to its viewers; on the stream's thread, which does not wait for this one.
  void pass_on(ViewerChannels::Message message) {
    const size_t bytes = message->payload.size();
    if (viewer_bytes_.fetch_add(bytes) > kMaxViewerPending) {
      viewer_bytes_.fetch_sub(bytes);
      ++viewer_dropped_;
      return;
    }
    asio::post(io_, [this, bytes, message = std::move(message)] {
      viewer_bytes_.fetch_sub(bytes);
      const uint64_t dropped = viewer_dropped_.exchange(0);
      for (const auto& viewer : viewers_) viewer->send(message, dropped);
    });
  }

  void greet(ViewClient& client) {
    client.send(std::make_shared<const ViewMessage>(
        ViewMessage{json_text({{"class", "VIEW"}, {"form", 1}, {"replay", control_ != nullptr}})}));
    if (!reports_.empty()) {
      client.send(std::make_shared<const ViewMessage>(ViewMessage{reports_.text()}));
    }
    if (last_map_) client.send(last_map_);
    for (const auto& [key, message] : last_frames_) client.send(message);
    if (ended_) client.send(ended_);
  }

  /// A page may ask for profiles, that of a replay may change its pace; everything else is ignored.
  void command(ViewClient& client, const std::string& text) {
    if (const auto wanted = parse_profiles_wanted(text)) client.set_profiles_wanted(*wanted);
    if (!control_) return;
    if (const auto asked = parse_view_command(text)) control_(*asked);
  }

  void remove(const std::shared_ptr<ViewClient>& client) {
    clients_.erase(client);
    client_count_ = clients_.size();
    if (clients_.empty()) tap_.set_wanted(false);
  }

  /// Sends the latest sweep and images, while somebody looks.
  void poll() {
    if (clients_.empty()) return;
    if (tap_.swap_sweep(sweep_)) {
      send_map();
      keep_frame(send_all(key_of("sweep", sweep_.lidar), encode_sweep(sweep_, rig_)));
    }
    for (size_t camera = 0; camera < tap_.cameras(); ++camera) {
      const bool profile = profile_due(camera);
      if (!tap_.swap_image(CameraIndex(camera), image_, profile)) continue;
      if (!camera::encode_jpeg(image_.frame, kJpegQuality, jpeg_)) continue;
      keep_frame(send_all(key_of("image", camera), encode_image(image_, jpeg_, rig_)));
      if (profile && !image_.returns.empty()) send_profile(camera);
    }
    timer_.expires_after(kFramePeriod);
    timer_.async_wait([this](beast::error_code error) {
      if (!error) poll();
    });
  }

  /// The last of each lidar and camera, for who opens a page when a replay does not go on.
  void keep_frame(const ViewClient::Message& message) {
    if (control_) last_frames_[message->key] = message;
  }

  bool profile_due(size_t camera) const {
    return std::chrono::steady_clock::now() >= next_profile_[camera] &&
           std::any_of(clients_.begin(), clients_.end(),
                       [](const auto& client) { return client->profiles_wanted(); });
  }

  /// Sends the profiles of the image in hand to the pages that show them.
  void send_profile(size_t camera) {
    const auto message = std::make_shared<const ViewMessage>(
        ViewMessage{profiler_.encode(image_), key_of("profile", camera)});
    for (const auto& client : clients_) {
      if (client->profiles_wanted()) client->send(message);
    }
    next_profile_[camera] = std::chrono::steady_clock::now() + kProfilePeriod;
  }

  /// Sends the street map around the vehicle, when it has left the middle of what was sent.
  void send_map() {
    if (map_ == nullptr || map_->empty() || !sweep_.map) return;
    const Eigen::Vector2d at = sweep_.map->T_map_vehicle.translation().head<2>();
    if (last_map_ && (at - map_middle_).norm() < kMapStep) return;
    map_middle_ = at;
    last_map_ = send_all("map", encode_map(*map_, at, sweep_.stamp));
  }

  ViewClient::Message send_all(std::string key, std::string data) {
    auto message =
        std::make_shared<const ViewMessage>(ViewMessage{std::move(data), std::move(key)});
    for (const auto& client : clients_) client->send(message);
    return message;
  }

  const ViewSettings settings_;
  const Rig rig_;
  const streetmap::SegmentMap* const map_;
  ViewTap& tap_;
  const ReplayControl control_;
  ViewerChannels* const channels_;
  const std::string session_ =
      std::to_string(std::chrono::system_clock::now().time_since_epoch().count());
  asio::io_context io_{1};
  tcp::acceptor acceptor_{io_};
  asio::local::stream_protocol::acceptor local_{io_};
  asio::steady_timer timer_{io_};
  uint16_t port_ = 0;
  std::atomic<size_t> client_count_ = 0, pending_ = 0;
  size_t connections_ = 0;
  std::list<std::weak_ptr<Connection>> silent_;  // have not asked yet, the oldest first
  std::set<std::shared_ptr<ViewClient>> clients_;
  std::set<std::shared_ptr<ViewerClient>> viewers_;
  std::atomic<size_t> viewer_bytes_ = 0;  // posted to this thread
  std::atomic<uint64_t> viewer_dropped_ = 0;
  ReportStore reports_{kMaxStoredReports};
  std::map<std::string, ViewClient::Message> last_frames_;  // by key
  ViewClient::Message ended_;                               // null: the drive goes on
  ViewClient::Message last_map_;
  Eigen::Vector2d map_middle_ = Eigen::Vector2d::Zero();  // of that, m, map frame
  ViewSweep sweep_;  // memory that is used again, as the next two
  ViewImage image_;
  std::vector<uint8_t> jpeg_;
  ViewProfiler profiler_;
  std::vector<std::chrono::steady_clock::time_point> next_profile_;  // by CameraIndex; of host time
  std::thread thread_;
};

ViewServer::ViewServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ViewServer::~ViewServer() = default;

Result<std::unique_ptr<ViewServer>> ViewServer::start(const ViewSettings& settings, const Rig& rig,
                                                      const streetmap::SegmentMap* map,
                                                      ViewTap& tap, ReplayControl control,
                                                      ViewerChannels* channels) {
  auto impl = std::make_unique<Impl>(settings, rig, map, tap, std::move(control), channels);
  if (auto listening = impl->listen(); !listening) return tl::unexpected(listening.error());
  return std::unique_ptr<ViewServer>(new ViewServer(std::move(impl)));
}

uint16_t ViewServer::port() const { return impl_->port(); }

std::string ViewServer::address() const {
  const ViewSettings& settings = impl_->settings();
  if (settings.port == 0 && !settings.path.empty()) return settings.path;
  const bool v6 = settings.bind.find(':') != std::string::npos;
  const std::string socket = settings.path.empty() ? "" : " and " + settings.path;
  return "http://" + (v6 ? "[" + settings.bind + "]" : settings.bind) + ":" +
         std::to_string(port()) + "/" + socket;
}

std::string ViewServer::page_address() const {
  const std::string& token = impl_->settings().token;
  return address() + (token.empty() ? "" : "?token=" + token);
}

void ViewServer::publish(ReportClass report_class, const std::string& line) {
  impl_->publish(report_class, line);
}

void ViewServer::end_drive() { impl_->end_drive(); }

size_t ViewServer::clients() const { return impl_->clients(); }

}  // namespace infuse::daemon
