#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <stop_token>

#include "daemon/pipeline/intake.hpp"
#include "daemon/pipeline/pacer.hpp"
#include "drivers/recording/drive_source.hpp"

namespace infuse::daemon {

/// The io thread of a replay: reads a drive and passes its events to the intake in drive time.
class DriveReader {
 public:
  /// `source` and `intake` must outlive this object.
  DriveReader(recording::DriveSource& source, std::optional<double> rate, Intake& intake)
      : source_(source), intake_(intake), pacer_(rate) {}

  /// Runs until the drive ends or a stop is requested. The last item passed on is always a kEnd.
  void run(std::stop_token stop);

  /// The pace, which any thread may change.
  Pacer& pacer() { return pacer_; }

  /// Bytes of the capture read so far, for a progress bar. Thread-safe.
  uint64_t capture_bytes() const { return capture_bytes_.load(std::memory_order_relaxed); }

 private:
  void process(const recording::DriveEvent& event);
  void process_datagram(const recording::DatagramEvent& event);

  recording::DriveSource& source_;
  Intake& intake_;
  Pacer pacer_;
  std::atomic<uint64_t> capture_bytes_{0};
};

}  // namespace infuse::daemon
