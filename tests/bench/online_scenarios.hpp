#pragma once

#include <benchmark/benchmark.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tests/bench/online_drive.hpp"
#include "tests/bench/quantile.hpp"
#include "tests/bench/rendered_drive.hpp"

/// The drives on which the monitor is measured. They are rendered once (`rendered_drive.hpp`).
namespace infuse::online {

inline constexpr double kNotDetected = 1e9;

/// Drives of 90 s of one rig: kept in memory.
inline const std::vector<std::string> kScenarios = {"online_2hz", "online_overcast",
                                                    "online_low_sun", "online_dusk"};
/// A lidar with 64 beams and a camera of 1.3 megapixels; only one such drive is kept in memory.
inline const std::vector<std::string> kLargeScenarios = {"online_large", "online_large_low_sun"};

/// Seed of the second world of a large drive.
inline const std::string kSecondWorldSeed = "101";

inline const Drive& load_drive(const std::string& scenario) {
  static std::map<std::string, std::unique_ptr<Drive>> drives;
  std::unique_ptr<Drive>& drive = drives[scenario];
  if (drive) return *drive;
  drive = std::make_unique<Drive>(read_drive(rendered_drive(scenario)));
  return *drive;
}

/// Large drives, each in two worlds.
inline std::vector<std::filesystem::path> large_drives() {
  std::vector<std::filesystem::path> drives;
  for (const std::string& name : kLargeScenarios) {
    drives.push_back(rendered_drive(name));
    drives.push_back(
        rendered_drive(name, name + "_" + kSecondWorldSeed, " --seed " + kSecondWorldSeed));
  }
  return drives;
}

/// Registers a benchmark that runs once and states its own time, s.
inline void register_run(const std::string& name, const auto& run) {
  benchmark::RegisterBenchmark(name.c_str(), run)
      ->UseManualTime()
      ->Iterations(1)
      ->Unit(benchmark::kSecond);
}

}  // namespace infuse::online
