#pragma once

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <string>

namespace infuse::daemon {

/// What a program left behind.
struct Ran {
  std::string output;
  int code = -1;  ///< −1: it could not be run, or did not exit by itself
};

/// Runs a shell line of the programs that were built with these tests; `output` is what the line
/// writes to standard output.
inline Ran run_line(const std::string& line) {
  Ran ran;
  std::FILE* pipe = ::popen(line.c_str(), "r");
  if (pipe == nullptr) return ran;
  std::array<char, 4096> bytes;
  for (size_t got; (got = std::fread(bytes.data(), 1, bytes.size(), pipe)) > 0;) {
    ran.output.append(bytes.data(), got);
  }
  const int status = ::pclose(pipe);
  ran.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return ran;
}

}  // namespace infuse::daemon
