#include "daemon/run/run_replay.hpp"

#include <spdlog/spdlog.h>

#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <iostream>

#include "daemon/command_line/arguments.hpp"
#include "daemon/command_line/progress_line.hpp"
#include "daemon/command_line/summary.hpp"
#include "daemon/pipeline/alert_log.hpp"
#include "daemon/pipeline/replay.hpp"
#include "daemon/run/daemon_host.hpp"
#include "daemon/run/open_messages.hpp"
#include "daemon/run/open_view.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::daemon {
namespace {

constexpr std::chrono::seconds kReplayClientTimeout{2};
constexpr std::chrono::milliseconds kProgressPeriod{100};
constexpr uint16_t kReplayViewPort = 9468;

/// Shows the progress of the replay at regular intervals.
void show_progress(ProgressLine& line, boost::asio::steady_timer& timer, const Replay& replay,
                   HostClock::time_point begin) {
  const Totals& totals = replay.totals();
  const double host_s = std::chrono::duration<double>(HostClock::now() - begin).count();
  const double drive_s = to_seconds(totals.now - totals.start);
  line.show(replay.progress(),
            fmt::format("{:.0f} s of drive, {:.1f} × real time", drive_s, drive_s / host_s));
  timer.expires_after(kProgressPeriod);
  timer.async_wait([&line, &timer, &replay, begin](boost::system::error_code error) {
    if (!error) show_progress(line, timer, replay, begin);
  });
}

/// Collects usable poses in the map frame if there is a map, otherwise in the odometry frame.
void collect_poses(Publisher& publisher, bool has_map,
                   std::vector<recording::TrajectoryPose>& poses) {
  publisher.set_pose_listener([&poses, has_map](const PoseReport& pose) {
    const bool right_frame = pose.frame == (has_map ? PoseFrame::kMap : PoseFrame::kOdom);
    if (right_frame && pose.usable()) poses.push_back({pose.stamp, pose.T_frame_vehicle});
  });
}

/// Does what a page asks for.
void set_pace(Pacer& pacer, const ViewCommand& command) {
  switch (command.kind) {
    case ViewCommand::Kind::kRate:
      return pacer.set_rate(command.rate);
    case ViewCommand::Kind::kStep:
      return pacer.step();
    case ViewCommand::Kind::kSeek:
      return pacer.seek(command.stamp);
    case ViewCommand::Kind::kSeekAlert:
      return pacer.seek_alert();
  }
}

/// Writes poses in the format that the file's extension selects.
Result<void> write_trajectory(const std::filesystem::path& path,
                              const std::vector<recording::TrajectoryPose>& poses) {
  const bool kitti = path.extension() == ".kitti";
  return text::write_text(path,
                          kitti ? recording::format_kitti(poses) : recording::format_tum(poses));
}

Result<std::optional<ReportsFile>> create_reports_file(const std::string& path) {
  if (path.empty()) return std::nullopt;
  return ReportsFile::create(path).map(
      [](ReportsFile file) { return std::optional<ReportsFile>(std::move(file)); });
}

}  // namespace

int run_replay(const RunOptions& options, const Config& config) {
  const auto rate = parse_rate(!options.rate.empty() ? options.rate : options.view ? "1" : "max");
  if (!rate) return print_error(kProgram, rate.error(), kUsage);
  const auto model = requested_model(options.model);
  if (!model) return print_error(kProgram, model.error(), kUsage);
  auto setup = open_drive(options.replay, config.lidars, {*model, options.calibration});
  if (!setup) return print_error(kProgram, setup.error(), kUnreadable);
  for (const Device& device : setup->devices) {
    spdlog::info("{}: {} ({}), on {}", device.name, device.model, device.model_reason,
                 device.endpoint);
  }
  auto file = create_reports_file(options.reports);
  if (!file) return print_error(kProgram, file.error(), kUsage);

  DaemonHost host(config, options.state);
  if (const auto opened = host.open(setup->rig, options.socket); !opened) {
    return print_error(kProgram, opened.error().error, opened.error().code);
  }
  ViewSettings view_settings = config.view;
  if (options.view && view_settings.port == 0) view_settings.port = kReplayViewPort;
  if (!options.view) view_settings.port = 0;
  Pacer* pacer = nullptr;  // when there is a replay
  PipelineOptions pipeline_options = host.pipeline_options();
  const LcmSettings no_lcm;  // live only
  auto messages =
      open_messages(options.mcap, view_settings.enabled(), no_lcm, message_setup(*setup));
  if (!messages) return print_error(kProgram, messages.error(), kUsage);
  auto view = open_view(
      view_settings, setup->rig, pipeline_options.street_map,
      [&](const ViewCommand& command) {
        boost::asio::post(host.io(), [&, command] {
          if (pacer != nullptr) set_pace(*pacer, command);
        });
      },
      messages->channels.get());
  if (!view) return print_error(kProgram, view.error(), kUsage);
  if (view->server) std::cerr << "view: " << view->server->address() << std::endl;
  pipeline_options.view = view->tap.get();
  pipeline_options.tap = messages->stream.get();
  boost::asio::steady_timer timer(host.io());
  ProgressLine line;
  double host_s = 0;
  Result<void> written_messages;
  bool stopped = false;
  const HostClock::time_point begin = HostClock::now();
  Replay replay(host.io(), *std::move(setup), {*rate, pipeline_options}, host.server(),
                *file ? &**file : nullptr, [&] {
                  host_s = std::chrono::duration<double>(HostClock::now() - begin).count();
                  timer.cancel();
                  written_messages = finish_messages(*messages);
                  host.finish(kReplayClientTimeout);
                });
  host.connect(replay.pipeline());
  pacer = &replay.pacer();
  publish_to_view(*view, replay.publisher(), [&] { pacer->reach_sweep(); });
  AlertLog alert_log;
  replay.publisher().add_alert_listener([&](const AlertReport& alert) {
    line.clear();
    alert_log.add(alert, spdlog::level::info);
    if (alert.raised) pacer->reach_alert();
  });
  start_messages(*messages, replay.pipeline(), false);
  std::vector<recording::TrajectoryPose> poses;
  if (!options.trajectory.empty()) {
    collect_poses(replay.publisher(), !pipeline_options.street_map->empty(), poses);
  }
  replay.start();
  if (line.visible() && !options.json) show_progress(line, timer, replay, begin);
  host.run([&] {
    stopped = true;
    replay.stop();
  });
  line.clear();

  Summary summary = summarise(replay);
  summary.host_s = host_s;
  summary.stopped = stopped;
  std::cout << (options.json ? json_text(to_json(summary)) + "\n" : to_text(summary)) << std::flush;
  if (!options.trajectory.empty()) {
    if (const auto written = write_trajectory(options.trajectory, poses); !written) {
      return print_error(kProgram, written.error(), kFailure);
    }
  }
  if (!written_messages) return print_error(kProgram, written_messages.error(), kFailure);
  if (*file) {
    if (const auto closed = (*file)->close(); !closed) {
      return print_error(kProgram, closed.error(), kFailure);
    }
  }
  return kDone;
}

}  // namespace infuse::daemon
