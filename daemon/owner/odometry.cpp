#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "daemon/command_line/arguments.hpp"
#include "daemon/command_line/progress_line.hpp"
#include "daemon/owner/commands.hpp"
#include "daemon/playback/find_lidar.hpp"
#include "daemon/playback/play_lidar.hpp"
#include "daemon/protocol/json.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "drivers/measurement/median.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "drivers/text/text_file.hpp"
#include "fusion/registration/lidar_trajectory.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kProgram = "infuse odometry";

struct OdometryArguments {
  std::string path;
  std::string output;
  std::string lidar;
  std::string model;
  bool json = false;
};

/// The trajectory and what is to be said about it.
class Track {
 public:
  explicit Track(const Eigen::Isometry3d& T_vehicle_lidar) : trajectory_(T_vehicle_lidar) {}

  void add(const Sweep& sweep) {
    const registration::LidarOdometryResult& result = trajectory_.add(sweep);
    ++sweeps_;
    if (!trajectory_.deskewed().usable()) {
      ++not_deskewed_;
      deskew_reason_ = trajectory_.deskewed().reason;
    }
    if (result.usable()) {
      add_pose(result);
    } else if (sweeps_ > 1) {  // the first sweep has nothing to be compared with
      ++not_registered_;
      reason_ = result.reason;
    }
    line_.show(std::nullopt, fmt::format("{} sweeps, {:.0f} m", sweeps_, length_));
  }

  void finish() { line_.clear(); }

  const std::vector<recording::TrajectoryPose>& poses() const { return poses_; }

  /// Why there is no pose.
  Error no_motion(const std::string& path) const {
    const std::string reason = sweeps_ == 0 ? "its packets make no sweeps" : reason_;
    return {"no motion was found" + (reason.empty() ? "" : ": " + reason), path,
            "infuse inspect says whether the lidar turns"};
  }

  void print_notes() const {
    if (not_deskewed_ > 0) {
      std::cerr << fmt::format("{}: note: {} sweep(s) not deskewed: {}\n", kProgram, not_deskewed_,
                               deskew_reason_);
    }
    if (not_registered_ > 0) {
      std::cerr << fmt::format("{}: note: {} sweep(s) not registered, the last: {}\n", kProgram,
                               not_registered_, reason_);
    }
    if (free_ > 0) {
      std::cerr << fmt::format("{}: note: {} sweep(s) do not determine the motion: {}\n", kProgram,
                               free_, free_text_);
    }
  }

  nlohmann::ordered_json json() const {
    return {{"sweeps", sweeps_},
            {"poses", poses_.size()},
            {"length", length_},
            {"median_speed", median_speed()},
            {"not_deskewed", not_deskewed_},
            {"not_registered", not_registered_},
            {"undetermined", free_}};
  }

  std::string text() const {
    return fmt::format("{} poses from {} sweeps, {:.2f} m, median speed {:.2f} m/s", poses_.size(),
                       sweeps_, length_, median_speed());
  }

 private:
  void add_pose(const registration::LidarOdometryResult& result) {
    // The sweep before is where this motion began: the first pose, at the start.
    if (poses_.empty()) {
      poses_.push_back(
          {result.motion.from, result.T_map_vehicle * result.motion.T_from_to.inverse()});
    }
    poses_.push_back({result.stamp, result.T_map_vehicle});
    const double step = result.motion.T_from_to.translation().norm();
    length_ += step;
    speeds_.push_back(step / to_seconds(result.motion.to - result.motion.from));
    if (result.registration.free_directions > 0) {
      ++free_;
      free_text_ = result.registration.free_directions_text();
    }
  }

  double median_speed() const {
    std::vector<double> sorted = speeds_;
    if (sorted.empty()) return 0;
    return median(sorted);
  }

  registration::LidarTrajectory trajectory_;
  ProgressLine line_;
  std::vector<recording::TrajectoryPose> poses_;
  std::vector<double> speeds_;  // m/s
  double length_ = 0;           // m
  uint64_t sweeps_ = 0, not_deskewed_ = 0, not_registered_ = 0, free_ = 0;
  const char *deskew_reason_ = "", *reason_ = "";
  std::string free_text_;
};

int run(const OdometryArguments& arguments) {
  const auto model = requested_model(arguments.model);
  if (!model) return print_error(kProgram, model.error(), kUsage);
  auto setup = open_drive(arguments.path, {}, {*model, {}});
  if (!setup) return print_error(kProgram, setup.error(), kUnreadable);
  const auto lidar = find_lidar(*setup, arguments.lidar);
  if (!lidar) return print_error(kProgram, lidar.error(), kUsage);

  Track track(setup->rig.lidars[*lidar].T_vehicle_lidar);
  play_lidar(
      *setup, *lidar, [&](const Sweep& sweep) { track.add(sweep); }, [](const VehicleSample&) {},
      [](const recording::DriveEvent&) { return true; });
  track.finish();
  for (const Error& note : setup->source.notes()) {
    std::cerr << kProgram << ": note: " << note.message() << "\n";
  }
  track.print_notes();
  if (track.poses().empty()) {
    return print_error(kProgram, track.no_motion(arguments.path), kFailure);
  }
  if (const auto written = text::write_text(arguments.output, recording::format_tum(track.poses()));
      !written) {
    return print_error(kProgram, written.error(), kFailure);
  }
  std::cout << (arguments.json ? json_text(track.json())
                               : track.text() + ", to " + arguments.output)
            << "\n";
  return kDone;
}

}  // namespace

Command declare_odometry(CLI::App& infuse) {
  CLI::App* app = infuse.add_subcommand(
      "odometry",
      "find the motion of the vehicle from one lidar alone, and write it as a trajectory");
  const auto arguments = std::make_shared<OdometryArguments>();
  app->add_option(
         "PATH", arguments->path,
         "a pcap or pcapng file, or a drive folder; the first part, a pattern or the folder of a "
         "split capture")
      ->required();
  app->add_option(
         "-o,--output", arguments->output,
         "trajectory of the vehicle to write, in TUM format: a pose at the middle of every "
         "sweep, in the vehicle frame at the first")
      ->required()
      ->type_name("FILE.tum");
  app->add_option("--lidar", arguments->lidar, "lidar, if there are several")->type_name("NAME");
  app->add_option("--model", arguments->model, "model of the lidar, if it cannot be inferred")
      ->type_name("NAME");
  app->add_flag("--json", arguments->json, "print the result as one JSON object");
  set_examples(*app, {"infuse odometry drive/ -o track.tum",
                      "infuse odometry drive.pcap -o track.tum --json"});
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace infuse::daemon
