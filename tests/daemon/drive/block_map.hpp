#pragma once

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "daemon/setup/drive_setup.hpp"
#include "daemon/tools/map/map_drive.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "fusion/motion/trajectory_error.hpp"
#include "tests/daemon/drive/simulated.hpp"
#include "tests/daemon/run_program.hpp"
#include "tests/folders.hpp"

namespace infuse::daemon {

inline constexpr const char* kBlock = R"(
seed = 3
duration_s = 76
[world]
map = "altfeld.osm"
route = [100, 104, 112, 110, 115, 117, 119, 107, 104, 112, 114]
build_radius_m = 70
ground_resolution = 1.0
[vehicle]
speed = 10
[[lidar]]
name = "top"
model = "VLP-16"
position = [1.0, 0.0, 1.95]
rays_per_pulse = 1
)";

/// The drive and its map, made once; "replayed" is the map before its closures are sought.
struct Made {
  TemporaryFolder folder;
  std::string error;
  std::vector<geometry::StampedPose> truth;

  Made() {
    const auto drive = simulate(folder / "drive", kBlock);
    const auto poses = recording::read_trajectory(folder / "drive/truth/poses.tum");
    if (!drive || !poses) {
      error = "the drive cannot be made";
      return;
    }
    for (const auto& pose : *poses) truth.push_back({pose.stamp, pose.T_frame_body});
    auto setup = open_drive(folder / "drive", {}, {});
    if (!setup || !replay_to_map(MapFolder(map("replayed")), *setup, 0, {})) {
      error = "the drive cannot be replayed";
      return;
    }
    std::filesystem::copy(map("replayed"), map(), std::filesystem::copy_options::recursive);
    const ProgramResult run = infuse("map " + (folder / "drive").string() + " -o " + map());
    if (run.code != 0) error = run.output;
  }

  std::string map(const std::string& name = "map") const { return (folder / name).string(); }

  static ProgramResult infused(const std::string& arguments) {
    return run_shell_command(programs_folder() + "/infused " + arguments + " 2>&1");
  }
  static ProgramResult infuse(const std::string& arguments) {
    return run_shell_command(programs_folder() + "/infuse " + arguments + " 2>&1");
  }
};

class BlockMap : public testing::Test {
 protected:
  // Under a sanitizer the drive takes minutes.
#ifdef __SANITIZE_ADDRESS__
  static constexpr bool kTooSlow = true;
#else
  static constexpr bool kTooSlow = false;
#endif
  static void SetUpTestSuite() { made_ = kTooSlow ? nullptr : new Made; }
  static void TearDownTestSuite() { delete made_; }
  void SetUp() override {
    if (kTooSlow) GTEST_SKIP() << "too slow with the address sanitizer";
    ASSERT_EQ(made_->error, "");
  }

  static std::string copy(const std::string& name, const std::string& of = "map") {
    std::filesystem::copy(made_->map(of), made_->map(name),
                          std::filesystem::copy_options::recursive);
    return made_->map(name);
  }

  /// Names and bytes of all files of a folder.
  static std::map<std::string, std::string> bytes_of(const std::string& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
      if (entry.is_regular_file()) {
        files[entry.path().lexically_relative(folder).string()] = read_file(entry.path());
      }
    }
    return files;
  }

  /// Root mean square error of the positions in a trajectory, m.
  static double error_of(const std::string& trajectory) {
    const auto poses = recording::read_trajectory(trajectory);
    EXPECT_TRUE(poses) << poses.error().message();
    std::vector<geometry::StampedPose> estimate;
    for (const auto& pose : *poses) estimate.push_back({pose.stamp, pose.T_frame_body});
    return motion::absolute_error(motion::pair_by_time(estimate, made_->truth)).translation.rms;
  }

  static inline Made* made_ = nullptr;
};

/// Another visit to the block: other cars stand and drive there.
inline std::string visit(const std::string& route, int seconds) {
  std::string scenario = kBlock;
  const auto replace = [&](const std::string& from, const std::string& to) {
    scenario.replace(scenario.find(from), from.size(), to);
  };
  replace("seed = 3", "seed = 8");
  replace("duration_s = 76", "duration_s = " + std::to_string(seconds));
  const std::string built = "[100, 104, 112, 110, 115, 117, 119, 107, 104, 112, 114]";
  replace("route = " + built, "seed = 3\nbuilt_along = " + built + "\nroute = " + route);
  return scenario;
}

inline std::vector<geometry::StampedPose> read_poses(const std::filesystem::path& file) {
  const auto poses = recording::read_trajectory(file);
  EXPECT_TRUE(poses) << poses.error().message();
  std::vector<geometry::StampedPose> out;
  for (const auto& pose : *poses) out.push_back({pose.stamp, pose.T_frame_body});
  return out;
}

}  // namespace infuse::daemon
