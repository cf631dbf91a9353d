// infused: the daemon. Runs the pipeline on a recorded drive and tells whoever listens.

#include <spdlog/spdlog.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <csignal>
#include <iostream>
#include <random>

#include "daemon/calibration/saved_calibrations.hpp"
#include "daemon/command_line/arguments.hpp"
#include "daemon/command_line/progress_line.hpp"
#include "daemon/command_line/summary.hpp"
#include "daemon/config/config.hpp"
#include "daemon/live/live_main.hpp"
#include "daemon/live/live_setup.hpp"
#include "daemon/pipeline/replay.hpp"
#include "daemon/server/server.hpp"
#include "daemon/service/logging.hpp"
#include "daemon/streetmap/street_map_file.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kProgram = "infused";

/// What was requested on the command line.
struct Arguments {
  std::string config;
  bool check_config = false;
  std::string replay;
  std::string rate = "max";
  std::string reports;
  std::string trajectory;
  std::string state;
  std::string socket;
  std::string model;
  bool json = false;
};

void declare_options(CLI::App& app, Arguments& arguments) {
  app.description(
      "infused: fuses lidar, cameras and odometry on the vehicle, and tells what it knows over a\n"
      "socket (see: infuse status, infuse watch).\n\n"
      "  infused --config infused.toml             run the sensors of this host\n"
      "  infused --replay drive.pcap               run the pipeline on a capture, print a summary\n"
      "  infused --replay drive/ --rate 1 --json   the same in real time, summary for machines");
  app.set_version_flag("--version", INFUSE_VERSION);
  app.add_option("--config", arguments.config, "configuration, TOML")->type_name("FILE");
  app.add_flag("--check-config", arguments.check_config,
               "only tell whether the configuration is right");
  app.add_option("--replay", arguments.replay, "a drive folder, or a bare pcap or pcapng")
      ->type_name("PATH");
  app.add_option("--rate", arguments.rate,
                 "of the replay: 1 is real time; max (the default) is as fast as it goes")
      ->type_name("R|max");
  app.add_option("--reports", arguments.reports,
                 "write every report to this file; the same drive gives the same bytes")
      ->type_name("FILE");
  app.add_option("--trajectory", arguments.trajectory,
                 "write where the vehicle was at the end of each sweep (on the map, where there is "
                 "one): TUM format, or KITTI's where "
                 "the name ends in .kitti")
      ->type_name("FILE");
  app.add_option("--state", arguments.state,
                 "of a replay: keep the calibrations in use in this folder, and begin with them; "
                 "without it a replay begins with the drive's own")
      ->type_name("DIR");
  app.add_option("--socket", arguments.socket, "where clients connect")->type_name("PATH");
  app.add_option("--model", arguments.model, "model of the lidar, where it cannot be inferred")
      ->type_name("NAME");
  app.add_flag("--json", arguments.json, "the summary as one JSON object");
}

/// Another number at each start, so that a client can tell a restart from a reconnect.
std::string make_session_id() {
  std::random_device device;
  const uint64_t number = uint64_t{device()} << 32 | device();
  return fmt::format("{:016x}", number);
}

/// Shows how far the replay is, ten times a second.
void show_progress(ProgressLine& line, boost::asio::steady_timer& timer, const Replay& replay,
                   HostClock::time_point begin) {
  const Totals& totals = replay.totals();
  const double host_s = std::chrono::duration<double>(HostClock::now() - begin).count();
  const double drive_s = to_seconds(totals.now - totals.start);
  line.show(replay.progress(),
            fmt::format("{:.0f} s of drive, {:.1f} × real time", drive_s, drive_s / host_s));
  timer.expires_after(std::chrono::milliseconds(100));
  timer.async_wait([&line, &timer, &replay, begin](boost::system::error_code error) {
    if (!error) show_progress(line, timer, replay, begin);
  });
}

/// Poses in the format that the file's name asks for.
Result<void> write_trajectory(const std::filesystem::path& path,
                              const std::vector<recording::TrajectoryPose>& poses) {
  const bool kitti = path.extension() == ".kitti";
  return text::write_text(path,
                          kitti ? recording::format_kitti(poses) : recording::format_tum(poses));
}

int run_replay(const Arguments& arguments, const Config& config) {
  const auto rate = parse_rate(arguments.rate);
  if (!rate) return print_error(kProgram, rate.error(), kUsage);
  std::optional<velodyne::Model> model;
  if (!arguments.model.empty()) {
    model = velodyne::find_model(arguments.model);
    if (!model) {
      return print_error(kProgram, {"unknown model '" + arguments.model + "'", "--model", ""},
                         kUsage);
    }
  }
  auto setup = open_drive(arguments.replay, config.lidars, model);
  if (!setup) return print_error(kProgram, setup.error(), kUnreadable);
  for (const Device& device : setup->devices) {
    spdlog::info("{}: {} ({}), on {}", device.name, device.model, device.model_reason,
                 device.endpoint);
  }
  SavedCalibrations calibrations(arguments.state.empty()
                                     ? std::filesystem::path()
                                     : std::filesystem::path(arguments.state) / kCalibrationsFile);
  for (const std::string& note : calibrations.restore(setup->rig)) spdlog::info("{}", note);
  std::optional<ReportsFile> file;
  if (!arguments.reports.empty()) {
    auto created = ReportsFile::create(arguments.reports);
    if (!created) return print_error(kProgram, created.error(), kUsage);
    file = *std::move(created);
  }

  const auto map = open_optional_street_map_file(config.folder, config.streetmap.map);
  if (!map) return print_error(kProgram, map.error(), kUnreadable);

  boost::asio::io_context io(1);
  Server server(io, config.socket, INFUSE_VERSION, make_session_id());
  if (const auto listening = listen(server, arguments.socket, config.socket); !listening) {
    return print_error(kProgram, listening.error(), kUsage);
  }
  boost::asio::signal_set signals(io, SIGINT, SIGTERM);
  boost::asio::steady_timer timer(io);
  ProgressLine line;
  struct {
    double host_s = 0;
    bool stopped = false;
  } ended;
  const HostClock::time_point begin = HostClock::now();
  Replay replay(
      io, *std::move(setup),
      {*rate, {config.health, config.odometry, config.streetmap, &map->map, config.calibration}},
      server, file ? &*file : nullptr, [&] {
        ended.host_s = std::chrono::duration<double>(HostClock::now() - begin).count();
        timer.cancel();
        signals.cancel();
        server.finish(std::chrono::seconds(2));
      });
  replay.publisher().on_calibration([&](const CalibrationReport& report) {
    if (const auto kept = calibrations.save(report); !kept) {
      spdlog::error("{}", kept.error().message());
    }
  });
  server.on_control([&](const Request& request) { return replay.handle_request(request); });
  signals.async_wait([&](boost::system::error_code error, int) {
    if (error) return;
    ended.stopped = true;
    signals.clear();  // a second signal ends at once
    replay.stop();
  });
  std::vector<recording::TrajectoryPose> poses;
  if (!arguments.trajectory.empty()) {
    replay.publisher().on_pose([&](const PoseReport& pose) {
      const bool right_frame = std::string_view(pose.frame) == (map->map.empty() ? "odom" : "map");
      if (right_frame && pose.usable()) poses.push_back({pose.stamp, pose.T_frame_vehicle});
    });
  }
  replay.start();
  if (line.visible() && !arguments.json) show_progress(line, timer, replay, begin);
  io.run();
  line.clear();

  Summary summary = summarise(replay);
  summary.host_s = ended.host_s;
  summary.stopped = ended.stopped;
  std::cout << (arguments.json ? to_json(summary).dump() + "\n" : to_text(summary)) << std::flush;
  if (!arguments.trajectory.empty()) {
    if (const auto written = write_trajectory(arguments.trajectory, poses); !written) {
      return print_error(kProgram, written.error(), kFailure);
    }
  }
  if (file) {
    if (const auto closed = file->close(); !closed)
      return print_error(kProgram, closed.error(), kFailure);
  }
  return kDone;
}

int run(int argc, char** argv) {
  CLI::App app;
  Arguments arguments;
  declare_options(app, arguments);
  if (const auto code = parse_arguments(app, argc, argv)) return *code;
  set_up_logging(kProgram);

  Config config;
  if (!arguments.config.empty()) {
    auto loaded = load_config(arguments.config);
    if (!loaded) return print_error(kProgram, loaded.error(), kUsage);
    config = *std::move(loaded);
  }
  spdlog::set_level(spdlog::level::from_str(config.log_level));
  if (arguments.check_config) {
    if (arguments.config.empty()) {
      return print_error(kProgram, {"there is no configuration to check", "", "--config FILE"},
                         kUsage);
    }
    if (const auto setup = set_up_live(config); !setup) {
      return print_error(kProgram, setup.error(), kUsage);
    }
    std::cout << arguments.config << ": the configuration is right\n";
    return kDone;
  }
  if (!arguments.replay.empty()) return run_replay(arguments, config);
  if (arguments.config.empty()) {
    return print_error(kProgram, {"nothing to do", "", "--config FILE, or --replay PATH"}, kUsage);
  }
  return run_live({arguments.config, arguments.socket, INFUSE_VERSION, make_session_id()}, config);
}

}  // namespace
}  // namespace infuse::daemon

int main(int argc, char** argv) { return infuse::daemon::run(argc, argv); }
