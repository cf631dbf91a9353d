#include "daemon/live/live_main.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <boost/asio/signal_set.hpp>
#include <csignal>
#include <cstdlib>

#include "daemon/calibration/saved_calibrations.hpp"
#include "daemon/command_line/arguments.hpp"
#include "daemon/live/live_pipeline.hpp"
#include "daemon/live/recording_controller.hpp"
#include "daemon/live/run_tracker.hpp"
#include "daemon/metrics/metrics_server.hpp"
#include "daemon/metrics/metrics_text.hpp"
#include "daemon/server/socket_path.hpp"
#include "daemon/service/service_manager.hpp"
#include "daemon/streetmap/street_map_file.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kProgram = "infused";
constexpr std::chrono::milliseconds kClientDrainTimeout{500};

// Keys of the configuration that a reload takes over, as far as their README says.
constexpr std::array kReloadableKeys = {"log_level", "socket", "health", "record"};

std::string status_text(const Publisher& publisher, size_t devices) {
  const Totals& totals = publisher.totals();
  const auto ok_sensors = std::count(totals.levels.begin(), totals.levels.end(), Level::kOk);
  return fmt::format("{} of {} sensors are OK, {} alerts since the start", ok_sensors, devices,
                     totals.alerts);
}

/// What a daemon does besides its pipeline: the service manager, its record, its signals.
class ServiceLifecycle {
 public:
  ServiceLifecycle(boost::asio::io_context& io, const LiveArguments& arguments,
                   const Config& config, LivePipeline& live, RecordingController& recordings,
                   Server& server, const receive::TimeBase& base)
      : arguments_(arguments),
        config_(config),
        live_(live),
        recordings_(recordings),
        server_(server),
        base_(base),
        run_tracker_(RunTracker::from_environment()),
        stop_signals_(io, SIGINT, SIGTERM),
        reload_signal_(io, SIGHUP) {
    live_.publisher().on_progress([this] { on_progress(); });
    stop_signals_.async_wait([this](boost::system::error_code error, int) {
      if (!error) on_stop_signal();
    });
    wait_for_reload();
  }

  /// After the pipeline's end.
  void finish() {
    stop_signals_.cancel();
    reload_signal_.cancel();
    run_tracker_.end_run(base_.now());
  }

 private:
  // A tick has passed through every thread: this is what feeds the watchdog.
  void on_progress() {
    recordings_.publish_updates();
    const std::string status = status_text(live_.publisher(), live_.setup().devices.size());
    if (!std::exchange(ready_, true)) {
      service_manager::notify_ready(status);
      if (auto alert = run_tracker_.begin_run(base_.now())) live_.publisher().publish_alert(*alert);
      return;
    }
    service_manager::notify_watchdog();
    service_manager::notify_status(status);
    if (auto alert = run_tracker_.save_if_due(base_.now())) live_.publisher().publish_alert(*alert);
  }

  void on_stop_signal() {
    service_manager::notify_stopping();
    stop_signals_.clear();  // a second signal ends at once
    live_.stop();
  }

  void wait_for_reload() {
    reload_signal_.async_wait([this](boost::system::error_code error, int) {
      if (error) return;
      reload_config();
      wait_for_reload();
    });
  }

  // The pipeline goes on with what it knows: tracks and calibrations stay.
  void reload_config() {
    service_manager::notify_reloading();
    const auto loaded = load_config(arguments_.config);
    if (!loaded) {
      spdlog::error("the configuration is kept as it was: {}", loaded.error().message());
    } else {
      apply_config(*loaded);
    }
    service_manager::notify_ready(status_text(live_.publisher(), live_.setup().devices.size()));
  }

  void apply_config(const Config& loaded) {
    spdlog::set_level(spdlog::level::from_str(loaded.log_level));
    server_.set_limits(loaded.socket);
    live_.publisher().set_health_options(loaded.health);
    recordings_.apply_settings(loaded.record);
    std::string applied, needs_restart;
    for (const std::string& key : changed_keys(config_, loaded)) {
      const bool reloadable =
          std::find(kReloadableKeys.begin(), kReloadableKeys.end(), key) != kReloadableKeys.end();
      (reloadable ? applied : needs_restart) += " " + key;
    }
    spdlog::info("the configuration was read again; taken over:{}",
                 applied.empty() ? " nothing, it says the same" : applied);
    if (needs_restart.empty()) return;
    spdlog::warn("not taken over, they need a restart:{} (systemctl restart infused)",
                 needs_restart);
  }

  const LiveArguments& arguments_;
  const Config& config_;
  LivePipeline& live_;
  RecordingController& recordings_;
  Server& server_;
  const receive::TimeBase& base_;
  RunTracker run_tracker_;
  boost::asio::signal_set stop_signals_;
  boost::asio::signal_set reload_signal_;
  bool ready_ = false;
};

/// Lets Prometheus look where the configuration says.
Result<void> listen_for_metrics(MetricsServer& metrics, const MetricsSettings& settings) {
  if (!settings.path.empty()) {
    if (auto listening = metrics.listen(settings.path); !listening) return listening;
  }
  if (settings.port == 0) return {};
  return metrics.listen_tcp(settings.port).map([](uint16_t) {});
}

/// Keeps what it finds there up to date, each second.
void publish_metrics(MetricsServer& metrics, const std::string& release, Publisher& publisher) {
  publisher.on_health([&metrics, release, &publisher](const HealthReport& health) {
    ProcessStats process;
    process.release = release;
    process.alerts = publisher.totals().alerts;
    measure_process(process);
    metrics.set_text(metrics_text(health, process));
  });
}

}  // namespace

Result<void> listen(Server& server, const std::string& socket, const ServerOptions& options) {
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
    spdlog::warn("nobody can watch: {}", listening.error().message());
  }
  return {};
}

int run_live(const LiveArguments& arguments, const Config& config) {
  auto setup = set_up_live(config);
  if (!setup) return print_error(kProgram, setup.error(), kUsage);
  for (const Error& note : setup->vehicle.notes) spdlog::warn("{}", note.message());
  for (const Device& device : setup->devices) {
    spdlog::info("{}: {} {} on {}", device.name, device.kind, device.model, device.endpoint);
  }
  if (setup->devices.empty()) {
    spdlog::warn("{}: no sensor is configured", arguments.config);
  }
  const char* folder = std::getenv("STATE_DIRECTORY");
  SavedCalibrations calibrations(folder == nullptr || *folder != '/'
                                     ? std::filesystem::path()
                                     : std::filesystem::path(folder) / kCalibrationsFile);
  for (const std::string& note : calibrations.restore(setup->rig)) spdlog::info("{}", note);
  boost::asio::io_context io(1);
  Server server(io, config.socket, arguments.release, arguments.session);
  if (const auto listening = listen(server, arguments.socket, config.socket); !listening) {
    return print_error(kProgram, listening.error(), kUsage);
  }
  MetricsServer metrics(io);
  if (const auto listening = listen_for_metrics(metrics, config.metrics); !listening) {
    return print_error(kProgram, listening.error(), kUsage);
  }
  const receive::TimeBase base;
  RecordingController recordings(config, *setup, base);
  std::function<void()> on_end;
  const auto map = open_optional_street_map_file(config.folder, config.streetmap.map);
  if (!map) return print_error(kProgram, map.error(), kUnreadable);
  LivePipeline live(
      io, *std::move(setup),
      {config.health, config.odometry, config.streetmap, &map->map, config.calibration}, server,
      [&] { on_end(); }, base, recordings.tap());
  for (const std::string& camera : calibrations.frozen_cameras()) {
    static_cast<void>(live.handle_request({.op = Request::Op::kFreeze, .device = camera}));
  }
  recordings.set_publisher(live.publisher());
  if (config.metrics.enabled()) publish_metrics(metrics, arguments.release, live.publisher());
  live.publisher().on_calibration([&](const CalibrationReport& report) {
    if (const auto kept = calibrations.save(report); !kept) {
      spdlog::error("{}", kept.error().message());
    }
  });
  server.on_control([&](const Request& request) {
    return request.op == Request::Op::kRecord ? recordings.handle_request(request)
                                              : live.handle_request(request);
  });
  ServiceLifecycle lifecycle(io, arguments, config, live, recordings, server, base);
  on_end = [&] {
    recordings.finish();
    lifecycle.finish();
    server.finish(kClientDrainTimeout);
    metrics.finish();
  };
  live.start();
  io.run();
  return kDone;
}

}  // namespace infuse::daemon
