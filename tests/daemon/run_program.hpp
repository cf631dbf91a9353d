#pragma once

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <string>

namespace infuse::daemon {

/// Result of a program.
struct ProgramResult {
  std::string output;
  int code = -1;  ///< −1: the program could not be run, or did not exit by itself
};

/// Runs a shell command line; `output` is its standard output.
inline ProgramResult run_shell_command(const std::string& line) {
  ProgramResult result;
  std::FILE* pipe = ::popen(line.c_str(), "r");
  if (pipe == nullptr) return result;
  std::array<char, 4096> bytes;
  for (size_t count; (count = std::fread(bytes.data(), 1, bytes.size(), pipe)) > 0;) {
    result.output.append(bytes.data(), count);
  }
  const int status = ::pclose(pipe);
  result.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return result;
}

}  // namespace infuse::daemon
