#pragma once

#include <string>

#include "daemon/command_line/arguments.hpp"

namespace infuse::daemon {

/// Name of the program in its messages.
inline constexpr const char* kProgram = "infused";

/// Prints why a run does not begin or has failed. Returns the exit code.
inline int refuse(const Error& error, ExitCode code = kUsage) {
  return print_error(kProgram, error, code);
}

/// Command-line arguments of `infused` for a run, live or a replay. An empty string means: not
/// given.
struct RunOptions {
  std::string config;  ///< configuration file; read again on SIGHUP
  std::string socket;  ///< where clients connect
  std::string mcap;    ///< file of ROS 2 messages to write

  std::string replay;       ///< drive folder or capture; empty: the sensors of this host
  std::string rate;         ///< factor of real time, or "max"; empty: 1 with a view, else "max"
  bool view = false;        ///< replay: a page in the browser
  bool no_wait = false;     ///< replay: begins and ends whether or not somebody looks
  std::string reports;      ///< file for every report
  std::string trajectory;   ///< file for the poses
  std::string state;        ///< folder of the saved calibrations of a replay
  std::string model;        ///< model of the lidar
  std::string calibration;  ///< db.xml of the lidar
  bool json = false;        ///< print the summary as JSON
};

}  // namespace infuse::daemon
