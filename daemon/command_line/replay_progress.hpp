#pragma once

#include <boost/asio/steady_timer.hpp>

#include "daemon/command_line/progress_line.hpp"
#include "daemon/pipeline/replay.hpp"

namespace infuse::daemon {

/// Shows the progress of a replay on the terminal, ten times a second, and measures its duration.
class ReplayProgress {
 public:
  explicit ReplayProgress(boost::asio::io_context& io) : timer_(io) {}

  /// Begins. `replay` outlives this; `visible`: false shows nothing.
  void start(const Replay& replay, bool visible);

  /// Removes the line until its next update.
  void clear() { line_.clear(); }

  /// Ends, when the replay has ended.
  void stop();

  /// Duration of the replay by the host's clock, s; after its end.
  double host_s() const { return host_s_; }

 private:
  void show(const Replay& replay);
  double since_begin_s() const;

  boost::asio::steady_timer timer_;
  ProgressLine line_;
  HostClock::time_point begin_ = HostClock::now();
  double host_s_ = 0;
};

}  // namespace infuse::daemon
