#include "daemon/run/run_live.hpp"

#include <spdlog/spdlog.h>

#include <cstdlib>
#include <memory>
#include <utility>
#include <vector>

#include "daemon/command_line/version.hpp"
#include "daemon/history/history_writer.hpp"
#include "daemon/mapping/map_folder.hpp"
#include "daemon/metrics/metrics_feed.hpp"
#include "daemon/mqtt/mqtt_feed.hpp"
#include "daemon/pipeline/alert_log.hpp"
#include "daemon/process/free_space.hpp"
#include "daemon/process/state_lock.hpp"
#include "daemon/sensors/live_pipeline.hpp"
#include "daemon/service/daemon_host.hpp"
#include "daemon/service/map_replacement.hpp"
#include "daemon/service/map_watch.hpp"
#include "daemon/service/ptp_clocks.hpp"
#include "daemon/service/service_lifecycle.hpp"
#include "daemon/service/system_clock.hpp"
#include "daemon/setup/live_setup.hpp"
#include "daemon/view/open_messages.hpp"
#include "daemon/view/open_view.hpp"

namespace infuse::daemon {
namespace {

constexpr std::chrono::milliseconds kLiveClientTimeout{500};
constexpr std::chrono::milliseconds kLiveBrokerTimeout{1000};

/// The service manager's state folder; empty if there is none.
std::filesystem::path state_folder() {
  const char* folder = std::getenv("STATE_DIRECTORY");
  return folder == nullptr || *folder != '/' ? "" : folder;
}

void log_sensors(const SensorSetup& setup, const std::string& config_file) {
  for (const Error& note : setup.vehicle.notes) spdlog::warn("{}", note.message());
  for (const Error& doubt : setup.doubts) spdlog::warn("{}", doubt.message());
  const std::vector<Sensor> sensors = setup.sensors();
  for (const auto& [id, device] : sensors) {
    spdlog::info("{}: {} {} on {}", device.name, device.kind, device.model, device.endpoint);
  }
  if (sensors.empty()) spdlog::warn("{}: no sensor is configured", config_file);
}

/// Watches the maps that are in use; what they are replaced by goes to the pipeline, and to who
/// draws it (null: nobody).
std::vector<std::unique_ptr<MapWatch>> watch_maps(const Config& config, const DaemonHost& host,
                                                  Pipeline& pipeline, ViewServer* view) {
  std::vector<std::unique_ptr<MapWatch>> watches;
  if (!config.streetmap.map.empty()) {
    const auto use = [&pipeline, view](const StreetMapFile& map, const std::stop_token& stop) {
      pipeline.replace({.street_map = map}, stop);
      if (view != nullptr) view->set_map(map);
    };
    watches.push_back(std::make_unique<MapWatch>("streetmap", config.resolve(config.streetmap.map),
                                                 host.street_map_digest(),
                                                 replace_street_map(config, use)));
  }
  if (config.map.directory.empty()) return watches;
  const auto use = [&pipeline](places::PlaceMap map, const std::stop_token& stop) {
    pipeline.replace({.places = std::move(map)}, stop);
  };
  watches.push_back(std::make_unique<MapWatch>(
      "map", config.resolve(config.map.directory) / map_file::kMap, host.places_digest(),
      replace_place_map(config, host.places_folder(), use)));
  return watches;
}

}  // namespace

int run_live(const RunOptions& options, const Config& config) {
  // The sensors, and what stands around the pipeline.
  auto setup = set_up_live(config);
  if (!setup) return refuse(setup.error());
  log_sensors(*setup, options.config);
  const std::filesystem::path state = state_folder();
  std::optional<host::FileDescriptor> lock;
  if (!state.empty()) {
    auto locked = lock_state(state);
    if (!locked) return refuse(locked.error());
    lock = *std::move(locked);
  }
  DaemonHost host(config, state);
  const auto opened = host.open(setup->rig, options.socket);
  if (!opened) return refuse(opened.error().error, opened.error().code);
  PipelineOptions pipeline_options = host.pipeline_options();

  // The services that can fail to open.
  MetricsServer metrics(host.io());
  const auto listening = metrics.listen(config.metrics);
  if (!listening) return refuse(listening.error());
  const auto broker = MqttFeed::start(config, state, version());
  if (!broker) return refuse(broker.error());
  auto messages =
      open_messages(options.mcap, config.view.enabled(), config.lcm, message_setup(*setup));
  if (!messages) return refuse(messages.error());
  auto view = open_view(config.view, setup->rig, pipeline_options.maps.street_map, nullptr,
                        messages->channels.get());
  if (!view) return refuse(view.error());

  // The pipeline.
  const host::TimeBase base;
  const auto now = [base] { return base.now(); };
  RecordingController recordings(config, *setup, now);
  pipeline_options.view = view->tap.get();
  pipeline_options.tap = messages->stream.get();
  std::function<void()> on_end;
  LivePipeline live(
      host.io(), *std::move(setup), pipeline_options, host.server(), [&] { on_end(); }, base,
      recordings.tap());
  pipeline_options.maps = {};  // the pipeline has them, until others take their place
  Publisher& publisher = live.publisher();

  // Who listens to it, and who asks it.
  recordings.set_publisher(publisher);
  MetricsFeed metrics_feed(metrics, version(), config);
  if (config.metrics.enabled()) publisher.add_sink(metrics_feed);
  AlertLog alert_log;
  publisher.add_alert_listener([&](const AlertReport& alert) { alert_log.add(alert); });
  HistoryWriter history(state);
  publisher.add_sink(history);
  if (!state.empty()) {
    publisher.add_store([&] {
      return StoreStatus{"history", free_space(state), history.problem()};
    });
    publisher.add_store([&] {
      return StoreStatus{"calibrations", free_space(state), host.calibrations_problem()};
    });
  }
  SystemClockQuery clock;
  publisher.set_clock([&clock] { return clock.ask(); });
  publisher.set_ptp_clocks([ptp = PtpClocks()] { return ptp.ask(); });
  if (const auto& folder = recordings.directory(); !folder.empty()) {
    publisher.add_store([&folder] { return StoreStatus{"recordings", free_space(folder), ""}; });
  }
  if (const McapRecording* file = messages->file.get()) {
    publisher.add_store([file, folder = std::filesystem::absolute(options.mcap).parent_path()] {
      return StoreStatus{"mcap", free_space(folder), file->problem()};
    });
  }
  publish_to_view(*view, publisher);
  start_messages(*messages, live.pipeline(), true);
  if (MqttFeed* feed = broker->get()) {
    publisher.add_sink(*feed);
    publisher.set_pose_listener([feed](const PoseReport& pose) { feed->add(pose); });
    publisher.add_queue([feed] { return feed->stats(); });
    publisher.add_store([feed, &state] {
      return StoreStatus{"mqtt", free_space(state), feed->disk_problem()};
    });
  }
  host.connect(live.pipeline(),
               [&](const Request& request) { return recordings.handle_request(request); });
  ServiceLifecycle lifecycle(
      {.io = host.io(),
       .publisher = publisher,
       .recordings = recordings,
       .server = host.server(),
       .stop = [&] { live.stop(); },
       .now = now,
       .maps = watch_maps(config, host, live.pipeline(), view->server.get())},
      options.config, config, host.calibration_damage());

  // The end, when the pipeline has ended.
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
