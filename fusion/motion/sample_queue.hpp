#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "drivers/measurement/vehicle_samples.hpp"
#include "fusion/motion/angular_velocity.hpp"

namespace infuse::motion {

/// Request for a pose at exactly this time, and for a clone of it.
struct PoseMark {
  Stamp stamp;
  bool clone = false;
};

/// Samples that arrive out of order, by time.
class SampleQueue {
 public:
  using Sample = std::variant<WheelOdometry, ImuSample, AngularVelocity, GnssFix, PoseMark>;
  struct Entry {
    Stamp stamp;
    Sample sample;
  };
  /// What the stamp of a sample says of it.
  enum class StampCheck : uint8_t {
    kInOrder,
    kLate,       ///< older than `now`
    kIsolated,   ///< far from all others: an error
    kClockStep,  ///< the second one far back: the clock has been set
  };

  /// Allocates all memory.
  SampleQueue();

  /// Compares a stamp with those before; `now` is the time processed so far (earliest: none).
  StampCheck check(Stamp stamp, Stamp now);

  bool full() const;
  Stamp oldest() const { return entries_.front().stamp; }
  /// The newest stamp of a sample; marks may lie ahead of the samples.
  Stamp newest() const { return newest_; }

  /// Inserts a sample in order of time, after those of the same time. The queue must not be full.
  void insert(Stamp stamp, const Sample& sample);

  /// Calls `process(const Entry&)` for the samples up to a time, and removes them.
  template <class Process>
  void drain(Stamp until, Process process) {
    size_t done = 0;
    while (done < entries_.size() && entries_[done].stamp <= until) process(entries_[done++]);
    entries_.erase(entries_.begin(), entries_.begin() + static_cast<std::ptrdiff_t>(done));
  }

  void clear();

 private:
  std::vector<Entry> entries_;  // in time order
  Stamp newest_ = Stamp::earliest();
  std::optional<Stamp> jumped_;  // the last stamp, if it was far from those before
};

}  // namespace infuse::motion
