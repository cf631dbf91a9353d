#pragma once

namespace infuse::daemon {

/// Exit codes of all programs of infuse.
enum ExitCode : int {
  kDone = 0,
  kFailure = 1,     ///< the answer is "no", or a check failed
  kUsage = 2,       ///< wrong usage or configuration
  kUnreadable = 3,  ///< input cannot be read
};

}  // namespace infuse::daemon
