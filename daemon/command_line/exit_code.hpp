#pragma once

namespace infuse::daemon {

/// What every program of infuse ends with.
enum ExitCode : int {
  kDone = 0,
  kFailure = 1,     ///< the answer is "no", or a check failed
  kUsage = 2,       ///< wrong usage or configuration
  kUnreadable = 3,  ///< input that cannot be read
};

}  // namespace infuse::daemon
