#include "daemon/view/view_server.hpp"

#include <pthread.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <map>
#include <set>
#include <thread>

#include "daemon/process/crash_note.hpp"
#include "daemon/protocol/json.hpp"
#include "daemon/view/report_store.hpp"
#include "daemon/view/view_client.hpp"
#include "daemon/view/view_frames.hpp"
#include "daemon/view/view_profiler.hpp"
#include "daemon/view/view_requests.hpp"
#include "daemon/view/viewer_client.hpp"
#include "drivers/camera/jpeg_encoder.hpp"

namespace infuse::daemon {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;

constexpr size_t kMaxPending = 512;  // reports that this thread has not read yet
constexpr std::chrono::milliseconds kFramePeriod{50};
constexpr std::chrono::seconds kProfilePeriod{2};  // of each camera; a profile takes 50 ms
constexpr int kJpegQuality = 75;
constexpr double kMapStep = 40;                         // m
constexpr size_t kMaxViewerPending = size_t{32} << 20;  // bytes of messages on their way here
constexpr size_t kMaxStoredReports = size_t{4} << 20;   // bytes of reports for pages opened later

/// Of the frames of a lidar or camera (see `ViewMessage::key`).
std::string key_of(const char* kind, size_t index) {
  return std::string(kind) + ":" + std::to_string(index);
}

}  // namespace

/// The thread and what runs on it.
class ViewServer::Impl {
 public:
  Impl(const ViewSettings& settings, const Rig& rig, const StreetMapFile& map, ViewTap& tap,
       ReplayControl control, ViewerChannels* channels)
      : settings_(settings),
        rig_(rig),
        map_(map),
        tap_(tap),
        control_(std::move(control)),
        channels_(channels),
        cameras_(tap.cameras()),
        profiler_(rig) {
    if (channels_ == nullptr) return;
    channels_->on_message([this](ViewerChannels::Message message) { pass_on(std::move(message)); });
  }

  ~Impl() {
    asio::post(io_, [this] {
      requests_.close();
      for (const auto& client : clients_) client->close();
      for (const auto& viewer : viewers_) viewer->close();
      io_.stop();
    });
    if (thread_.joinable()) thread_.join();
    tap_.set_wanted(false);
    if (!settings_.path.empty()) ::unlink(settings_.path.c_str());
  }

  Result<void> listen() {
    if (auto listening = requests_.listen(); !listening) return listening;
    thread_ = std::thread([this] {
      pthread_setname_np(pthread_self(), "view");
      use_crash_stack();
      io_.run();
    });
    return {};
  }

  uint16_t port() const { return requests_.port(); }
  std::string address() const { return requests_.address(); }
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

  void set_map(const StreetMapFile& map) {
    asio::post(io_, [this, map] {
      map_ = map;
      last_map_.reset();
    });
  }

  void end_drive() {
    asio::post(io_, [this] {
      ended_ = std::make_shared<const ViewMessage>(ViewMessage{json_text({{"class", "END"}})});
      for (const auto& client : clients_) client->send(ended_);
    });
  }

 private:
  /// The latest image of a camera.
  struct CameraView {
    ViewImage image;
    bool has_profile = false;                            ///< that of the image has been sent
    std::chrono::steady_clock::time_point next_profile;  ///< of host time
  };

  ViewRequests::Handlers handlers() {
    ViewRequests::Handlers handlers{.open = [this] { return clients_.size() + viewers_.size(); },
                                    .on_page = std::bind_front(&Impl::open_page, this)};
    if (channels_ != nullptr) handlers.on_viewer = std::bind_front(&Impl::open_viewer, this);
    return handlers;
  }

  void open_page(ViewStream stream, ViewClient::Request request) {
    const auto client = std::make_shared<ViewClient>(
        std::move(stream),
        ViewClient::Handlers{
            .on_open = [this](const auto& opened) { greet(*opened); },
            .on_command = [this](const auto& from, const auto& text) { command(*from, text); },
            .on_end = [this](const auto& ended) { remove(ended); }});
    clients_.insert(client);
    client_count_ = clients_.size();
    tap_.set_wanted(true);
    if (control_) control_({.kind = ViewCommand::Kind::kOpened});
    if (clients_.size() == 1) poll();
    client->accept(std::move(request));
  }

  void open_viewer(ViewStream stream, ViewClient::Request request, std::string_view protocol) {
    const auto viewer =
        std::make_shared<ViewerClient>(std::move(stream), *channels_, session_,
                                       [this](const auto& ended) { viewers_.erase(ended); });
    viewers_.insert(viewer);
    if (control_) control_({.kind = ViewCommand::Kind::kOpened});
    viewer->accept(std::move(request), protocol);
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
    if (const auto wanted = parse_profiles_wanted(text)) {
      client.set_profiles_wanted(*wanted);
      may_show_profiles_ = true;
      for (CameraView& camera : cameras_) camera.has_profile = false;
    }
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
    for (size_t index = 0; index < cameras_.size(); ++index) {
      CameraView& camera = cameras_[index];
      const bool profile = profile_due(camera);
      // A replay may pause or end before a page shows profiles: then its last image gives one.
      const bool with_returns = profile || (control_ != nullptr && may_show_profiles_);
      if (tap_.swap_image(CameraIndex(index), camera.image, with_returns)) {
        camera.has_profile = false;
        if (camera::encode_jpeg(camera.image.frame, kJpegQuality, jpeg_)) {
          keep_frame(send_all(key_of("image", index), encode_image(camera.image, jpeg_, rig_)));
        }
      }
      if (profile && !camera.image.returns.empty()) send_profile(camera);
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

  bool profile_due(const CameraView& camera) const {
    return !camera.has_profile && std::chrono::steady_clock::now() >= camera.next_profile &&
           std::any_of(clients_.begin(), clients_.end(),
                       [](const auto& client) { return client->profiles_wanted(); });
  }

  /// Sends the profiles of the image in hand to the pages that show them.
  void send_profile(CameraView& camera) {
    const auto message = std::make_shared<const ViewMessage>(
        ViewMessage{profiler_.encode(camera.image), key_of("profile", camera.image.camera)});
    for (const auto& client : clients_) {
      if (client->profiles_wanted()) client->send(message);
    }
    camera.has_profile = true;
    camera.next_profile = std::chrono::steady_clock::now() + kProfilePeriod;
  }

  /// Sends the street map around the vehicle, when it has left the middle of what was sent.
  void send_map() {
    if (map_.map.empty() || !sweep_.map) return;
    const Eigen::Vector2d at = sweep_.map->T_map_vehicle.translation().head<2>();
    if (last_map_ && (at - map_middle_).norm() < kMapStep) return;
    map_middle_ = at;
    last_map_ = send_all("map", encode_map(map_.map, at, sweep_.stamp));
  }

  ViewClient::Message send_all(std::string key, std::string data) {
    auto message =
        std::make_shared<const ViewMessage>(ViewMessage{std::move(data), std::move(key)});
    for (const auto& client : clients_) client->send(message);
    return message;
  }

  const ViewSettings settings_;
  const Rig rig_;
  StreetMapFile map_;
  ViewTap& tap_;
  const ReplayControl control_;
  ViewerChannels* const channels_;
  const std::string session_ =
      std::to_string(std::chrono::system_clock::now().time_since_epoch().count());
  asio::io_context io_{1};
  ViewRequests requests_{io_, settings_, handlers()};
  asio::steady_timer timer_{io_};
  std::atomic<size_t> client_count_ = 0, pending_ = 0;
  std::set<std::shared_ptr<ViewClient>> clients_;
  std::set<std::shared_ptr<ViewerClient>> viewers_;
  std::atomic<size_t> viewer_bytes_ = 0;  // posted to this thread
  std::atomic<uint64_t> viewer_dropped_ = 0;
  ReportStore reports_{kMaxStoredReports};
  std::map<std::string, ViewClient::Message> last_frames_;  // by key
  ViewClient::Message ended_;                               // null: the drive goes on
  ViewClient::Message last_map_;
  Eigen::Vector2d map_middle_ = Eigen::Vector2d::Zero();  // of that, m, map frame
  ViewSweep sweep_;                  // memory that is used again, as the next two
  bool may_show_profiles_ = false;   // a page has said whether it shows them
  std::vector<CameraView> cameras_;  // by CameraIndex
  std::vector<uint8_t> jpeg_;
  ViewProfiler profiler_;
  std::thread thread_;
};

ViewServer::ViewServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ViewServer::~ViewServer() = default;

Result<std::unique_ptr<ViewServer>> ViewServer::start(const ViewSettings& settings, const Rig& rig,
                                                      const StreetMapFile& map, ViewTap& tap,
                                                      ReplayControl control,
                                                      ViewerChannels* channels) {
  auto impl = std::make_unique<Impl>(settings, rig, map, tap, std::move(control), channels);
  if (auto listening = impl->listen(); !listening) return tl::unexpected(listening.error());
  return std::unique_ptr<ViewServer>(new ViewServer(std::move(impl)));
}

uint16_t ViewServer::port() const { return impl_->port(); }

std::string ViewServer::address() const { return impl_->address(); }

std::string ViewServer::page_address() const {
  const std::string& token = impl_->settings().token;
  return address() + (token.empty() ? "" : "?token=" + token);
}

void ViewServer::publish(ReportClass report_class, const std::string& line) {
  impl_->publish(report_class, line);
}

void ViewServer::set_map(const StreetMapFile& map) { impl_->set_map(map); }

void ViewServer::end_drive() { impl_->end_drive(); }

size_t ViewServer::clients() const { return impl_->clients(); }

}  // namespace infuse::daemon
