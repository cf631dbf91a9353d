#include "daemon/run/run_replay.hpp"

#include <spdlog/spdlog.h>

#include <boost/asio/post.hpp>
#include <iostream>

#include "daemon/command_line/replay_progress.hpp"
#include "daemon/command_line/summary.hpp"
#include "daemon/command_line/trajectory_output.hpp"
#include "daemon/pipeline/alert_log.hpp"
#include "daemon/pipeline/replay.hpp"
#include "daemon/service/daemon_host.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "daemon/view/open_messages.hpp"
#include "daemon/view/open_view.hpp"
#include "daemon/view/replay_control.hpp"
#include "drivers/text/printable.hpp"

namespace infuse::daemon {
namespace {

constexpr std::chrono::seconds kReplayClientTimeout{2};
constexpr uint16_t kReplayViewPort = 9468;

Result<std::optional<ReportsFile>> create_reports_file(const std::string& path) {
  if (path.empty()) return std::nullopt;
  return ReportsFile::create(path).map(
      [](ReportsFile file) { return std::optional<ReportsFile>(std::move(file)); });
}

/// The view is served only where the command line asks for it.
ViewSettings view_settings(const RunOptions& options, const Config& config) {
  ViewSettings settings = config.view;
  if (options.view && settings.port == 0) settings.port = kReplayViewPort;
  if (!options.view) settings.port = 0;
  settings.path.clear();
  return settings;
}

void print_summary(const Summary& summary, bool json) {
  std::cout << (json ? json_text(to_json(summary)) + "\n" : text::printable(to_text(summary), "\n"))
            << std::flush;
}

}  // namespace

int run_replay(const RunOptions& options, const Config& config) {
  // The sensors of the drive, and what stands around the pipeline.
  const auto rate = parse_rate(!options.rate.empty() ? options.rate : options.view ? "1" : "max");
  if (!rate) return refuse(rate.error());
  const auto model = requested_model(options.model);
  if (!model) return refuse(model.error());
  auto setup = open_drive(options.replay, config.lidars, {*model, options.calibration});
  if (!setup) return refuse(setup.error(), kUnreadable);
  for (const auto& [id, device] : setup->sensors()) {
    spdlog::info("{}: {} ({}), on {}", device.name, device.model, device.model_reason,
                 device.endpoint);
  }
  auto file = create_reports_file(options.reports);
  if (!file) return refuse(file.error());
  DaemonHost host(config, options.state);
  const auto opened = host.open(setup->rig, options.socket);
  if (!opened) return refuse(opened.error().error, opened.error().code);
  PipelineOptions pipeline_options = host.pipeline_options();

  // The services that can fail to open.
  const ViewSettings viewed = view_settings(options, config);
  const LcmSettings no_lcm;  // live only
  auto messages = open_messages(options.mcap, viewed.enabled(), no_lcm, message_setup(*setup));
  if (!messages) return refuse(messages.error());
  Pacer* pacer = nullptr;  // when there is a replay
  const ReplayControl control = [&](const ViewCommand& command) {
    boost::asio::post(host.io(), [&, command] {
      if (pacer != nullptr) set_pace(*pacer, command);
    });
  };
  auto view = open_view(viewed, setup->rig, pipeline_options.maps.street_map, control,
                        messages->channels.get());
  if (!view) return refuse(view.error());
  if (view->server) std::cerr << "view: " << view->server->page_address() << std::endl;

  // The pipeline.
  pipeline_options.view = view->tap.get();
  pipeline_options.tap = messages->stream.get();
  std::function<void()> on_end;
  Replay replay(host.io(), *std::move(setup), {*rate, pipeline_options}, host.server(),
                *file ? &**file : nullptr, [&] { on_end(); });
  Publisher& publisher = replay.publisher();
  pacer = &replay.pacer();

  // Who listens to it, and who asks it.
  host.connect(replay.pipeline());
  publish_to_view(*view, publisher, [&] { pacer->reach_sweep(); });
  ReplayProgress progress(host.io());
  AlertLog alert_log;
  publisher.add_alert_listener([&](const AlertReport& alert) {
    progress.clear();
    alert_log.add(alert, spdlog::level::info);
    if (alert.raised) pacer->reach_alert();
  });
  start_messages(*messages, replay.pipeline(), false);
  TrajectoryOutput trajectory(options.trajectory);
  trajectory.collect(publisher, !pipeline_options.maps.street_map.map.empty() ||
                                    pipeline_options.maps.places.has_value());

  // The end, when the pipeline has ended.
  const bool waits = view->server && !options.no_wait;
  bool stopped = false, ended = false;
  ExitCode code = kDone;
  on_end = [&] {
    progress.stop();
    Summary summary = summarise(replay);
    summary.host_s = progress.host_s();
    summary.stopped = stopped;
    print_summary(summary, options.json);
    for (const auto& written : {trajectory.write(), finish_messages(*messages),
                                *file ? (*file)->close() : Result<void>()}) {
      if (!written) code = static_cast<ExitCode>(refuse(written.error(), kFailure));
    }
    ended = true;
    if (!waits || stopped) return host.finish(kReplayClientTimeout);
    view->server->end_drive();
    std::cerr << "the drive has ended; Ctrl-C ends the view" << std::endl;
  };
  if (waits) pacer->hold();
  replay.start();
  progress.start(replay, !options.json);
  host.run([&] {
    if (ended) return host.finish(kReplayClientTimeout);
    stopped = true;
    replay.stop();
  });
  return code;
}

}  // namespace infuse::daemon
