#pragma once

#include <string>
#include <vector>

namespace infuse::daemon {

/// What a program printed, and how it ended.
struct ProgramEnd {
  std::string output;  ///< standard output and error, at most 8 MiB
  int code = 127;      ///< 127: it could not be started or was killed
};

/// Runs a program, found by PATH, without a shell and without input.
ProgramEnd run_program(const std::vector<std::string>& words);

}  // namespace infuse::daemon
