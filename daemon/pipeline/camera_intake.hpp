#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "daemon/health/stream_counters.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// Intake of one camera: reads image files without decoding them, and counts them and the missing
/// ones. Runs on the io thread.
class CameraIntake {
 public:
  /// Maximum size of an image file.
  static constexpr size_t kMaxBytes = 64 << 20;

  /// Reads an image file into `encoded`, which keeps its memory. Returns false, and counts it as
  /// refused, if it cannot be read.
  bool read_image(Stamp stamp, uint64_t sequence, const std::filesystem::path& path,
                  std::vector<uint8_t>& encoded);

  /// Counts an image, and those missing before it.
  void count(Stamp stamp, uint64_t sequence);

  const StreamCounters& counters() const { return counters_; }

 private:
  StreamCounters counters_;
  uint64_t next_ = 0;  // expected sequence number
};

}  // namespace infuse::daemon
