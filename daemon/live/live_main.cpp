#include "daemon/live/live_main.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <boost/asio/signal_set.hpp>
#include <csignal>
#include <cstdlib>

#include "daemon/calibration/saved_calibrations.hpp"
#include "daemon/command_line/arguments.hpp"
#include "daemon/live/live.hpp"
#include "daemon/live/record_desk.hpp"
#include "daemon/live/run_record.hpp"
#include "daemon/metrics/metrics_server.hpp"
#include "daemon/metrics/metrics_text.hpp"
#include "daemon/server/socket_path.hpp"
#include "daemon/service/service_manager.hpp"
#include "daemon/streetmap/street_map_file.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kProgram = "infused";
constexpr std::chrono::milliseconds kPatienceWithClients{500};

// Keys of the configuration that a reload takes over, as far as their README says.
constexpr std::array kReloadable = {"log_level", "socket", "health", "record"};

std::string status_text(const Publisher& publisher, size_t devices) {
  const Totals& totals = publisher.totals();
  const auto well = std::count(totals.levels.begin(), totals.levels.end(), Level::kOk);
  return fmt::format("{} of {} sensors are OK, {} alerts since the start", well, devices,
                     totals.alerts);
}

/// What a daemon does besides its pipeline: the service manager, its record, its signals.
class Attendant {
 public:
  Attendant(boost::asio::io_context& io, const LiveArguments& arguments, const Config& config,
            Live& live, RecordDesk& records, Server& server, const receive::TimeBase& base)
      : arguments_(arguments),
        config_(config),
        live_(live),
        records_(records),
        server_(server),
        base_(base),
        record_(RunRecord::from_environment()),
        ending_(io, SIGINT, SIGTERM),
        reloading_(io, SIGHUP) {
    live_.publisher().on_progress([this] { progress(); });
    ending_.async_wait([this](boost::system::error_code error, int) {
      if (!error) end();
    });
    wait_for_reload();
  }

  /// After the pipeline's end.
  void finish() {
    ending_.cancel();
    reloading_.cancel();
    record_.end(base_.now());
  }

 private:
  // A tick has passed through every thread: this is what feeds the watchdog.
  void progress() {
    records_.look_after();
    const std::string status = status_text(live_.publisher(), live_.setup().devices.size());
    if (!std::exchange(ready_, true)) {
      service_manager::ready(status);
      if (auto alert = record_.begin(base_.now())) live_.publisher().tell_alert(*alert);
      return;
    }
    service_manager::alive();
    service_manager::status(status);
    if (auto alert = record_.keep(base_.now())) live_.publisher().tell_alert(*alert);
  }

  void end() {
    service_manager::stopping();
    ending_.clear();  // a second signal ends at once
    live_.stop();
  }

  void wait_for_reload() {
    reloading_.async_wait([this](boost::system::error_code error, int) {
      if (error) return;
      reload();
      wait_for_reload();
    });
  }

  // The pipeline goes on with what it knows: tracks and calibrations stay.
  void reload() {
    service_manager::reloading();
    const auto loaded = load_config(arguments_.config);
    if (!loaded) {
      spdlog::error("the configuration is kept as it was: {}", loaded.error().message());
    } else {
      take_over(*loaded);
    }
    service_manager::ready(status_text(live_.publisher(), live_.setup().devices.size()));
  }

  void take_over(const Config& loaded) {
    spdlog::set_level(spdlog::level::from_str(loaded.log_level));
    server_.set_limits(loaded.socket);
    live_.publisher().set(loaded.health);
    records_.set(loaded.record);
    std::string taken, waiting;
    for (const std::string& key : changed_keys(config_, loaded)) {
      const bool now = std::find(kReloadable.begin(), kReloadable.end(), key) != kReloadable.end();
      (now ? taken : waiting) += " " + key;
    }
    spdlog::info("the configuration was read again; taken over:{}",
                 taken.empty() ? " nothing, it says the same" : taken);
    if (waiting.empty()) return;
    spdlog::warn("not taken over, they need a restart:{} (systemctl restart infused)", waiting);
  }

  const LiveArguments& arguments_;
  const Config& config_;
  Live& live_;
  RecordDesk& records_;
  Server& server_;
  const receive::TimeBase& base_;
  RunRecord record_;
  boost::asio::signal_set ending_;
  boost::asio::signal_set reloading_;
  bool ready_ = false;
};

/// Lets Prometheus look where the configuration says.
Result<void> listen(MetricsServer& metrics, const MetricsSettings& settings) {
  if (!settings.path.empty()) {
    if (auto listening = metrics.listen(settings.path); !listening) return listening;
  }
  if (settings.port == 0) return {};
  return metrics.listen_tcp(settings.port).map([](uint16_t) {});
}

/// Keeps what it finds there up to date, each second.
void feed(MetricsServer& metrics, const std::string& release, Publisher& publisher) {
  publisher.on_health([&metrics, release, &publisher](const std::string& message) {
    ProcessFigures process;
    process.release = release;
    process.alerts = publisher.totals().alerts;
    measure_process(process);
    metrics.set(metrics_text(Json::parse(message), process));
  });
}

}  // namespace

Result<void> listen(Server& server, const std::string& socket, const ServerOptions& options) {
  if (options.tcp_port != 0) {
    if (auto port = server.listen_tcp(options.tcp_port); !port) {
      return tl::unexpected(port.error());
    }
  }
  auto sockets = service_manager::take_sockets();
  if (!sockets.empty()) return server.adopt(sockets.front().release());
  const std::string& path = socket.empty() ? options.path : socket;
  if (!path.empty()) return server.listen(path);
  const std::filesystem::path usual = default_socket_paths().front();
  if (const auto listening = server.listen(usual); !listening) {
    spdlog::warn("nobody can watch: {}", listening.error().message());
  }
  return {};
}

int run_live(const LiveArguments& arguments, const Config& config) {
  auto setup = set_up_live(config);
  if (!setup) return complain(kProgram, setup.error(), kUsage);
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
  for (const std::string& told : calibrations.restore(setup->rig)) spdlog::info("{}", told);
  boost::asio::io_context io(1);
  Server server(io, config.socket, arguments.release, arguments.session);
  if (const auto listening = listen(server, arguments.socket, config.socket); !listening) {
    return complain(kProgram, listening.error(), kUsage);
  }
  MetricsServer metrics(io);
  if (const auto listening = listen(metrics, config.metrics); !listening) {
    return complain(kProgram, listening.error(), kUsage);
  }
  const receive::TimeBase base;
  RecordDesk records(config, *setup, base);
  std::function<void()> on_end;
  const auto map = open_street_map_if_any(config.folder, config.streetmap.map);
  if (!map) return complain(kProgram, map.error(), kUnreadable);
  Live live(
      io, *std::move(setup),
      {config.health, config.odometry, config.streetmap, &map->map, config.calibration}, server,
      [&] { on_end(); }, base, records.tap());
  for (const std::string& camera : calibrations.frozen()) {
    static_cast<void>(live.ask({.op = Request::Op::kFreeze, .device = camera}));
  }
  records.tell_to(live.publisher());
  if (config.metrics.any()) feed(metrics, arguments.release, live.publisher());
  live.publisher().on_calibration([&](const CalibrationReport& report) {
    if (const auto kept = calibrations.keep(report); !kept) {
      spdlog::error("{}", kept.error().message());
    }
  });
  server.on_control([&](const Request& request) {
    return request.op == Request::Op::kRecord ? records.ask(request) : live.ask(request);
  });
  Attendant attendant(io, arguments, config, live, records, server, base);
  on_end = [&] {
    records.finish();
    attendant.finish();
    server.finish(kPatienceWithClients);
    metrics.finish();
  };
  live.start();
  io.run();
  return kDone;
}

}  // namespace infuse::daemon
