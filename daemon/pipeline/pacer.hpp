#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <stop_token>

#include "daemon/pipeline/stream_item.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// Paces a replay at a multiple of real time. Decides when an event is passed on, never which: the
/// reports of a replay are the same whatever is asked for here.
class Pacer {
 public:
  /// `rate`: 1 is real time; nothing: as fast as possible.
  explicit Pacer(std::optional<double> rate) : rate_(rate) {}

  /// Returns when the event of this stamp is due, or a stop is requested. A pause of more than 10 s
  /// of drive time, or a step back, is skipped.
  void wait_until(Stamp stamp, std::stop_token stop);

  /// Lets no event pass until `begin`; before the replay starts.
  void hold() { held_ = true; }

  /// Ends `hold`; from any thread.
  void begin();

  /// Changes the rate, from any thread; 0 pauses.
  void set_rate(double rate);

  /// Passes on events until `reach_sweep`, then pauses; from any thread. Not as fast as possible:
  /// what has been read when the sweep is reported shall not contain the next one.
  void step();

  /// Passes on the events before `stamp` as fast as possible, then goes on at the rate, or stays
  /// paused; from any thread. An earlier stamp changes nothing.
  void seek(Stamp stamp);

  /// Does the same until `reach_alert`.
  void seek_alert();

  /// An alert was raised: ends `seek_alert` and pauses; from any thread.
  void reach_alert();

  /// A sweep was reported: ends a step; from any thread.
  void reach_sweep();

 private:
  static constexpr Duration kMaxPause{10'000'000'000};
  static constexpr double kStepRate = 0.25;

  bool is_free(Stamp stamp) const;
  void end_seek();

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<double> rate_;
  std::optional<Stamp> drive_start_;  // of the present rate
  std::optional<Stamp> seek_;         // events before it are not paced
  bool held_ = false;
  bool seeking_alert_ = false;
  bool stepping_ = false;
  Stamp previous_;
  HostClock::time_point host_start_;
};

}  // namespace infuse::daemon
