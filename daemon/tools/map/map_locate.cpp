#include "daemon/tools/map/map_locate.hpp"

#include <spdlog/fmt/fmt.h>

#include <array>
#include <iostream>
#include <optional>
#include <vector>

#include "daemon/command_line/arguments.hpp"
#include "daemon/command_line/progress_line.hpp"
#include "daemon/mapping/place_map.hpp"
#include "daemon/playback/find_lidar.hpp"
#include "daemon/playback/play_lidar.hpp"
#include "daemon/protocol/json.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "daemon/tools/map/lidar_replay.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "drivers/text/text_file.hpp"
#include "fusion/features/air_returns.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kLocateProgram = "infuse map locate";

using places::LocaliserPose;
using places::LocaliserState;

/// What the localisation of a drive gave.
class LocatedDrive {
 public:
  void add(const LocaliserPose& pose, double step) {
    way_ += step;
    if (sweeps_ == 0) begin_ = pose.stamp;
    ++sweeps_;
    ++by_state_[static_cast<size_t>(pose.state)];
    reason_ = pose.reason;
    place_ = pose.place;
    if (!pose.usable()) {
      was_tracking_ = false;
      return;
    }
    if (!was_tracking_) ++starts_;
    was_tracking_ = true;
    if (poses_.empty()) {
      found_after_ = to_seconds(pose.stamp - begin_);
      found_way_ = way_;
    }
    poses_.push_back({pose.stamp, pose.T_map_vehicle});
  }

  const std::vector<recording::TrajectoryPose>& poses() const { return poses_; }
  const char* reason() const { return reason_; }

  std::string progress() const {
    return fmt::format("{} sweeps, {:.0f} m, {} of them TRACKING", sweeps_, way_, poses_.size());
  }

  nlohmann::ordered_json json() const {
    return {{"sweeps", sweeps_},
            {"way", way_},
            {"tracking", count(LocaliserState::kTracking)},
            {"unsure", count(LocaliserState::kUnsure)},
            {"lost", count(LocaliserState::kLost)},
            {"times_found", starts_},
            {"found_after_s", found_after_},
            {"found_after_m", found_way_},
            {"place_probability", place_.best},
            {"runner_up_probability", place_.runner_up},
            {"nowhere_probability", place_.nowhere},
            {"reason", reason_}};
  }

  std::string text() const {
    std::string out = fmt::format("{} sweeps, {:.0f} m: TRACKING {}, UNSURE {}, LOST {}", sweeps_,
                                  way_, count(LocaliserState::kTracking),
                                  count(LocaliserState::kUnsure), count(LocaliserState::kLost));
    if (!poses_.empty()) {
      out += fmt::format("; found after {:.1f} s and {:.0f} m", found_after_, found_way_);
    }
    out += fmt::format(
        "\nlast search: probability of the best place {:.3f}, of the next {:.3f}, of nowhere "
        "{:.3f}",
        place_.best, place_.runner_up, place_.nowhere);
    return out;
  }

 private:
  uint64_t count(LocaliserState state) const { return by_state_[static_cast<size_t>(state)]; }

  std::vector<recording::TrajectoryPose> poses_;  // while TRACKING
  std::array<uint64_t, 3> by_state_{};
  uint64_t sweeps_ = 0, starts_ = 0;
  Stamp begin_;
  double way_ = 0, found_after_ = 0, found_way_ = 0;  // m, s, m
  bool was_tracking_ = false;
  const char* reason_ = "no sweep";
  places::PlaceProbabilities place_;
};

/// Why the map cannot be read, or nothing.
std::optional<Error> locate(SensorSetup& setup, size_t lidar, places::Localiser& localiser,
                            LocatedDrive& located) {
  LidarReplay odometry(setup, lidar);
  features::AirReturns air;
  ProgressLine line;
  std::optional<Error> failed;
  const auto on_sweep = [&](const Sweep& sweep, const motion::DeskewedSweep& deskewed,
                            const mapping::SweepMotion& motion) {
    if (failed) return;
    air.find(sweep);
    const auto pose = localiser.add({air.without(deskewed.x), deskewed.y, deskewed.z},
                                    sweep.reflectivity, motion);
    if (!pose) {
      failed = pose.error();
      return;
    }
    located.add(*pose, motion.T_from_to.translation().norm());
    line.show(std::nullopt, located.progress());
  };
  play_lidar(
      setup, lidar, [&](const Sweep& sweep) { odometry.add_sweep(sweep); },
      [&](const VehicleSample& sample) { odometry.add_sample(sample); },
      [&](const recording::DriveEvent& event) {
        odometry.process_due(event.stamp, on_sweep);
        return !failed;
      });
  if (!failed) odometry.finish(on_sweep);
  line.clear();
  return failed;
}

}  // namespace

int run_map_locate(const MapLocateArguments& arguments) {
  auto map = open_place_map(MapFolder(arguments.map));
  if (!map) return print_error(kLocateProgram, map.error(), kUnreadable);
  auto setup = open_drive(arguments.drive, {}, {});
  if (!setup) return print_error(kLocateProgram, setup.error(), kUnreadable);
  const auto lidar = find_lidar(*setup, arguments.lidar);
  if (!lidar) return print_error(kLocateProgram, lidar.error(), kUsage);
  places::Localiser localiser(*std::move(map), setup->rig.lidars[*lidar].T_vehicle_lidar);
  LocatedDrive located;
  if (const auto failed = locate(*setup, *lidar, localiser, located)) {
    return print_error(kLocateProgram, *failed, kUnreadable);
  }
  for (const Error& note : setup->source.notes()) {
    std::cerr << kLocateProgram << ": note: " << note.message() << "\n";
  }
  std::cout << (arguments.json ? json_text(located.json()) : located.text()) << "\n";
  if (located.poses().empty()) {
    return print_error(
        kLocateProgram,
        {std::string("not found on the map: ") + located.reason(), arguments.drive, ""}, kFailure);
  }
  if (arguments.output.empty()) return kDone;
  const auto written = text::write_text(arguments.output, recording::format_tum(located.poses()));
  return written ? kDone : print_error(kLocateProgram, written.error(), kFailure);
}

}  // namespace infuse::daemon
