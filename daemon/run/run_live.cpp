#include "daemon/run/run_live.hpp"

#include <spdlog/spdlog.h>

#include <cstdlib>

#include "daemon/command_line/arguments.hpp"
#include "daemon/command_line/version.hpp"
#include "daemon/history/history_writer.hpp"
#include "daemon/metrics/metrics_server.hpp"
#include "daemon/metrics/metrics_text.hpp"
#include "daemon/mqtt/mqtt_publisher.hpp"
#include "daemon/mqtt/report_topics.hpp"
#include "daemon/pipeline/alert_log.hpp"
#include "daemon/run/daemon_host.hpp"
#include "daemon/run/open_messages.hpp"
#include "daemon/run/open_view.hpp"
#include "daemon/run/service_lifecycle.hpp"
#include "daemon/sensors/live_pipeline.hpp"

namespace infuse::daemon {
namespace {

constexpr std::chrono::milliseconds kLiveClientTimeout{500};
constexpr std::chrono::milliseconds kLiveBrokerTimeout{1000};

/// The service manager's state folder; empty if there is none.
std::filesystem::path state_folder() {
  const char* folder = std::getenv("STATE_DIRECTORY");
  return folder == nullptr || *folder != '/' ? "" : folder;
}

/// Opens the configured sockets for Prometheus.
Result<void> listen_for_metrics(MetricsServer& metrics, const MetricsSettings& settings) {
  if (!settings.path.empty()) {
    if (auto listening = metrics.listen(settings.path); !listening) return listening;
  }
  if (settings.port == 0) return {};
  return metrics.listen_tcp(settings.port).map([](uint16_t) {});
}

/// Updates the metrics with every HEALTH report.
void publish_metrics(MetricsServer& metrics, Publisher& publisher) {
  publisher.add_health_listener([&metrics, &publisher](const HealthReport& health) {
    ProcessStats process;
    process.release = version();
    process.alerts = publisher.totals().alerts;
    measure_process(process);
    metrics.set_text(metrics_text(health, process));
  });
}

/// Keeps the history of alerts, calibrations and health.
void write_history(HistoryWriter& history, Publisher& publisher) {
  publisher.add_alert_listener([&history](const AlertReport& alert) { history.add(alert); });
  publisher.add_calibration_listener(
      [&history](const CalibrationReport& report) { history.add(report); });
  publisher.add_health_listener([&history](const HealthReport& health) { history.add(health); });
}

/// Connects to the configured broker; nothing if there is none.
Result<std::unique_ptr<MqttPublisher>> connect_to_broker(const Config& config) {
  if (!config.mqtt.enabled()) return nullptr;
  MqttSettings settings = config.mqtt;
  for (std::string* file : {&settings.ca_file, &settings.certificate_file, &settings.key_file,
                            &settings.password_file}) {
    if (!file->empty()) *file = config.resolve(*file);
  }
  const std::filesystem::path folder = state_folder();
  return MqttPublisher::start(settings, folder.empty() ? folder : folder / "mqtt.db", version());
}

/// Publishes alerts, calibrations, health and poses to the broker.
void publish_to_broker(MqttPublisher& broker, ReportTopics& topics, Publisher& publisher) {
  const auto add = [&broker, &topics](const auto& report) {
    if (auto selected = topics.select(report)) broker.add(*std::move(selected));
  };
  publisher.add_alert_listener(add);
  publisher.add_calibration_listener(add);
  publisher.add_health_listener(add);
  publisher.set_pose_listener(add);
  publisher.add_queue([&broker] { return broker.stats(); });
}

}  // namespace

int run_live(const RunOptions& options, const Config& config) {
  auto setup = set_up_live(config);
  if (!setup) return print_error(kProgram, setup.error(), kUsage);
  for (const Error& note : setup->vehicle.notes) spdlog::warn("{}", note.message());
  for (const Error& doubt : setup->doubts) spdlog::warn("{}", doubt.message());
  for (const Device& device : setup->devices) {
    spdlog::info("{}: {} {} on {}", device.name, device.kind, device.model, device.endpoint);
  }
  if (setup->devices.empty()) spdlog::warn("{}: no sensor is configured", options.config);

  DaemonHost host(config, state_folder());
  if (const auto opened = host.open(setup->rig, options.socket); !opened) {
    return print_error(kProgram, opened.error().error, opened.error().code);
  }
  MetricsServer metrics(host.io());
  if (const auto listening = listen_for_metrics(metrics, config.metrics); !listening) {
    return print_error(kProgram, listening.error(), kUsage);
  }
  const auto broker = connect_to_broker(config);
  if (!broker) return print_error(kProgram, broker.error(), kUsage);
  PipelineOptions pipeline_options = host.pipeline_options();
  auto messages =
      open_messages(options.mcap, config.view.enabled(), config.lcm, message_setup(*setup));
  if (!messages) return print_error(kProgram, messages.error(), kUsage);
  auto view = open_view(config.view, setup->rig, pipeline_options.street_map, nullptr,
                        messages->channels.get());
  if (!view) return print_error(kProgram, view.error(), kUsage);
  pipeline_options.view = view->tap.get();
  pipeline_options.tap = messages->stream.get();
  const receive::TimeBase base;
  const auto now = [base] { return base.now(); };
  RecordingController recordings(config, *setup, now);
  std::function<void()> on_end;
  LivePipeline live(
      host.io(), *std::move(setup), pipeline_options, host.server(), [&] { on_end(); }, base,
      recordings.tap());
  recordings.set_publisher(live.publisher());
  if (config.metrics.enabled()) publish_metrics(metrics, live.publisher());
  AlertLog alert_log;
  live.publisher().add_alert_listener([&](const AlertReport& alert) { alert_log.add(alert); });
  HistoryWriter history(state_folder());
  write_history(history, live.publisher());
  publish_to_view(*view, live.publisher());
  start_messages(*messages, live.pipeline(), true);
  ReportTopics topics(config.mqtt);
  if (*broker) publish_to_broker(**broker, topics, live.publisher());
  host.connect(live.pipeline(),
               [&](const Request& request) { return recordings.handle_request(request); });
  ServiceLifecycle lifecycle({.io = host.io(),
                              .publisher = live.publisher(),
                              .recordings = recordings,
                              .server = host.server(),
                              .stop = [&] { live.stop(); },
                              .now = now},
                             options.config, config, host.calibration_damage());
  on_end = [&] {
    recordings.finish();
    if (const auto closed = finish_messages(*messages); !closed)
      spdlog::error("{}", closed.error().message());
    history.finish();
    if (*broker) (*broker)->finish(kLiveBrokerTimeout);
    lifecycle.finish();
    host.finish(kLiveClientTimeout);
    metrics.finish();
  };
  live.start();
  host.run([&] { lifecycle.stop(); });
  return kDone;
}

}  // namespace infuse::daemon
