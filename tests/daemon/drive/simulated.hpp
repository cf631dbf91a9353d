#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/daemon/pipeline/run_replay.hpp"
#include "tests/daemon/run_program.hpp"
#include "tests/folders.hpp"

namespace infuse::daemon {

/// Totals of a simulated drive.
struct SimulatedDrive {
  uint64_t packets = 0;  ///< data packets of the lidars
  uint64_t images = 0;
  uint64_t can_frames = 0;
};

/// Makes the drive that `scenario` (TOML) describes, on one of the maps of fixtures/maps; it is
/// rendered once (fixtures/simulate_once).
inline Result<SimulatedDrive> simulate(const std::filesystem::path& folder,
                                       const std::string& scenario) {
  const TemporaryFolder made;
  const std::filesystem::path source = source_folder();
  for (const auto& map : std::filesystem::directory_iterator(source / "fixtures/maps")) {
    std::filesystem::create_symlink(map.path(), made / map.path().filename().string());
  }
  std::ofstream(made / "test.toml") << scenario;
  const ProgramResult run =
      run_shell_command((source / "fixtures/simulate_once").string() + " " + programs_folder() +
                        "/infuse-simulate-unversioned " + (made / "test.toml").string() +
                        " --json -o " + folder.string());
  if (run.code != 0) return tl::unexpected(Error{"cannot be simulated", folder.string(), ""});
  const auto summary = nlohmann::json::parse(run.output);
  return SimulatedDrive{summary["packets"], summary["images"], summary["can_frames"]};
}

/// A few seconds of a car in a street with all its sensors, small and quickly made.
inline Result<SimulatedDrive> simulate_car(const std::filesystem::path& folder, double seconds) {
  return simulate(folder, "duration_s = " + std::to_string(seconds) + R"(
[world]
map = "altfeld.osm"
route = [100, 104, 112]
build_radius_m = 40
ground_resolution = 1.0
[vehicle]
speed = 10
start_speed = 10
[[lidar]]
model = "VLP-16"
rays_per_pulse = 1
position = [1.0, 0.0, 1.9]
[[camera]]
width = 96
height = 64
fx = 60
samples = 1
format = "jpg"
position = [1.5, 0.0, 1.6]
)");
}

inline std::string read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void write_file(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

}  // namespace infuse::daemon
