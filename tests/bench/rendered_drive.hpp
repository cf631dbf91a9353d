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

/// Returns the folder of a drive shared by benchmarks, which change nothing in it; it is rendered
/// once (fixtures/simulate_once). `scenario`: one of fixtures/scenarios; `drive`,
/// `extra_arguments`: name of the folder and further arguments, if different from the scenario's.
/// Prints an error if the simulation fails; the folder is then missing.
inline std::filesystem::path rendered_drive(const std::string& scenario,
                                            const std::string& drive = {},
                                            const std::string& extra_arguments = {}) {
  const std::filesystem::path folder = bench_drives_folder() / (drive.empty() ? scenario : drive);
  std::filesystem::remove_all(folder);
  const std::string command = source_folder() + "/fixtures/simulate_once --link " +
                              programs_folder() + "/infuse-simulate-unversioned " +
                              source_folder() + "/fixtures/scenarios/" + scenario + ".toml" +
                              extra_arguments + " -o " + folder.string();
  std::fprintf(stderr, "%s\n", command.c_str());
  if (std::system((command + " >&2").c_str()) == 0) return folder;
  std::fprintf(stderr, "failed\n");
  std::filesystem::remove_all(folder);
  return folder;
}

}  // namespace infuse
