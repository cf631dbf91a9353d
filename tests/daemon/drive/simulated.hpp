#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "fixtures/simulator/drive_writer.hpp"
#include "tests/daemon/pipeline/run_replay.hpp"
#include "tests/folders.hpp"

namespace infuse::daemon {

/// Makes the drive that `scenario` (TOML) describes, on one of the maps of fixtures/maps.
inline Result<simulator::DriveSummary> simulate(const std::filesystem::path& folder,
                                                const std::string& scenario) {
  const std::filesystem::path maps = std::filesystem::path(source_folder()) / "fixtures/maps";
  auto parsed = simulator::parse_scenario(scenario, "test.toml", maps);
  if (!parsed) return tl::unexpected(parsed.error());
  auto simulation = simulator::Simulation::create(*parsed, 2);
  if (!simulation) return tl::unexpected(simulation.error());
  return write_drive(*simulation, folder, [](double) {});
}

/// A few seconds of a car in a street with all its sensors, small and quickly made.
inline Result<simulator::DriveSummary> simulate_car(const std::filesystem::path& folder,
                                                    double seconds) {
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
