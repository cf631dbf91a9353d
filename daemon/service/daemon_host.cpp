#include "daemon/service/daemon_host.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <csignal>
#include <random>
#include <utility>

#include "daemon/command_line/version.hpp"
#include "daemon/mapping/place_map.hpp"
#include "daemon/process/service_manager.hpp"
#include "daemon/server/socket_path.hpp"
#include "fusion/geometry/plane_length.hpp"

namespace infuse::daemon {
namespace {

/// A different number at every start, so that a client can distinguish a restart from a reconnect.
std::string make_session_id() {
  std::random_device device;
  const uint64_t number = uint64_t{device()} << 32 | device();
  return fmt::format("{:016x}", number);
}

std::filesystem::path calibrations_file(const std::filesystem::path& state_folder) {
  return state_folder.empty() ? std::filesystem::path() : state_folder / kCalibrationsFile;
}

}  // namespace

Result<StreetMapFile> open_street_map(const Config& config) {
  const StreetMapSettings& settings = config.streetmap;
  if (settings.map.empty()) return {};
  auto map = open_street_map_file(config.folder / settings.map);
  if (map && settings.initial_location && !map->map.frame().georeferenced) {
    return fail("the street map has no latitude and longitude", settings.map,
                "give x, y and yaw_deg instead of lat, lon and heading_deg");
  }
  if (!map) return map;
  const auto start = stated_start(settings, map->map.frame());
  if (start && !map->map.covers(start->pose.x, start->pose.y)) {
    const double distance = geometry::plane_length(start->pose.x, start->pose.y) / 1e3;
    return fail(
        fmt::format("the initial pose, {:.1f} km from the map's origin, lies outside the map",
                    distance),
        settings.map, "`infuse streetmap` states the map's origin and size");
  }
  return map;
}

Result<std::optional<OpenedPlaces>> open_place_map(const Config& config) {
  if (config.map.directory.empty()) return std::optional<OpenedPlaces>();
  const auto folder = MapFolder(config.resolve(config.map.directory)).hold();
  if (!folder) return tl::unexpected(folder.error());
  auto map = open_place_map(*folder);
  if (!map) return tl::unexpected(map.error());
  auto digest = map_digest(*folder);
  if (!digest) return tl::unexpected(digest.error());
  return OpenedPlaces{*std::move(map), *std::move(digest), folder->id()};
}

DaemonHost::DaemonHost(const Config& config, const std::filesystem::path& state_folder)
    : config_(config),
      server_(io_, config.socket, version(), make_session_id()),
      calibrations_(calibrations_file(state_folder)) {
  server_.set_configuration(config.digest, config.version);
}

tl::expected<void, StartError> DaemonHost::open(Rig& rig, const std::string& socket) {
  for (const std::string& note : calibrations_.restore(rig)) spdlog::info("{}", note);
  auto map = open_street_map(config_);
  if (!map) return tl::unexpected(StartError{map.error(), kUnreadable});
  street_map_digest_ = map->digest;
  maps_.street_map = *std::move(map);
  auto places = open_place_map(config_);
  if (!places) return tl::unexpected(StartError{places.error(), kUnreadable});
  if (*places) {
    maps_.places = std::move((*places)->map);
    places_digest_ = std::move((*places)->digest);
    places_folder_ = (*places)->folder;
  }
  const std::string& lidar = config_.map.lidar;
  if (maps_.places && !lidar.empty() && rig.find_lidar(lidar) == nullptr) {
    return tl::unexpected(StartError{{"[map] names a lidar that is not there", lidar, ""}, kUsage});
  }
  if (const auto listening = listen_for_clients(server_, socket, config_.socket); !listening) {
    return tl::unexpected(StartError{listening.error(), kUsage});
  }
  return {};
}

PipelineOptions DaemonHost::pipeline_options() {
  return {.health = config_.health,
          .odometry = config_.odometry,
          .streetmap = config_.streetmap,
          .maps = std::exchange(maps_, {}),
          .calibration = config_.calibration,
          .places_lidar = config_.map.lidar};
}

void DaemonHost::connect(Pipeline& pipeline, RequestHandler on_record) {
  connect(
      pipeline.publisher(),
      [&pipeline](const CalibrationCommand& command) { pipeline.post(command); },
      std::move(on_record));
}

void DaemonHost::connect(Publisher& publisher, CommandHandler on_command,
                         RequestHandler on_record) {
  on_command_ = std::move(on_command);
  on_record_ = std::move(on_record);
  for (const CalibrationCommand& command : calibrations_.restore_commands()) on_command_(command);
  publisher.set_calibration_ledger([this](CalibrationReport& report) { complete(report); });
  server_.on_control([this](const Request& request) { return handle_request(request); });
}

Result<std::string> DaemonHost::handle_request(const Request& request) {
  if (request.op == Request::Op::kRecord) {
    if (!on_record_) return fail("a replay cannot be recorded");
    return on_record_(request).map([] { return std::string(); });
  }
  if (!config_.calibration.monitored) {
    return fail("calibrations are not monitored", "", "set monitor = true in [calibration]");
  }
  const auto decision = calibrations_.decide(request);
  if (!decision) return tl::unexpected(decision.error());
  for (const CalibrationCommand& command : decision->commands) on_command_(command);
  return decision->note;
}

// The store's status tells why, and raises the alert.
void DaemonHost::complete(CalibrationReport& report) {
  const auto saved = calibrations_.observe(report);
  calibrations_problem_ = saved ? "" : saved.error().message();
}

void DaemonHost::run(std::function<void()> on_stop) {
  stop_signals_.async_wait(
      [this, on_stop = std::move(on_stop)](boost::system::error_code error, int) {
        if (error) return;
        stop_signals_.clear();          // another SIGINT ends the process at once
        std::signal(SIGTERM, SIG_IGN);  // may be repeated, by a service manager
        on_stop();
      });
  io_.run();
}

void DaemonHost::finish(std::chrono::milliseconds client_timeout) {
  stop_signals_.cancel();
  server_.finish(client_timeout);
}

Result<void> listen_for_clients(Server& server, const std::string& socket,
                                const ServerOptions& options) {
  if (options.tcp_port != 0) {
    if (auto port = server.listen_tcp(options.tcp_port); !port) {
      return tl::unexpected(port.error());
    }
  }
  auto sockets = service_manager::inherited_sockets();
  if (!sockets.empty()) return server.adopt(sockets.front().release());
  const std::string& path = socket.empty() ? options.path : socket;
  if (!path.empty()) return server.listen(path);
  const std::filesystem::path default_path = default_socket_paths().front();
  if (const auto listening = server.listen(default_path); !listening) {
    spdlog::warn("no socket for clients: {}", listening.error().message());
  }
  return {};
}

}  // namespace infuse::daemon
