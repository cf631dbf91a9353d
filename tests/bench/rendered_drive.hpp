#pragma once

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "tests/folders.hpp"

namespace infuse {

/// Folder of the benchmark drives: in the build folder, or INFUSE_BENCH_DRIVES.
inline std::filesystem::path bench_drives_folder() {
  const char* given = std::getenv("INFUSE_BENCH_DRIVES");
  return given == nullptr ? programs_folder() + "/../bench-drives" : given;
}

/// Returns the folder of a drive shared by benchmarks; it is simulated on first use.
/// `scenario`: one of fixtures/scenarios;
/// `drive`, `extra_arguments`: name of the folder and further arguments, if different from the
/// scenario's. Prints an error if the simulation fails; the folder is then missing.
inline std::filesystem::path rendered_drive(const std::string& scenario,
                                            const std::string& drive = {},
                                            const std::string& extra_arguments = {}) {
  const std::filesystem::path folder = bench_drives_folder() / (drive.empty() ? scenario : drive);
  if (std::filesystem::exists(folder / "drive.toml")) return folder;
  std::filesystem::create_directories(folder.parent_path());
  const std::string command = programs_folder() + "/infuse-simulate " + source_folder() +
                              "/fixtures/scenarios/" + scenario + ".toml" + extra_arguments +
                              " -o " + folder.string();
  std::fprintf(stderr, "%s\n", command.c_str());
  if (std::system((command + " >&2").c_str()) != 0) std::fprintf(stderr, "failed\n");
  return folder;
}

}  // namespace infuse
