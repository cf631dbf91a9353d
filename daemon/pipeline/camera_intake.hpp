#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "daemon/health/stream_counters.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// One camera: reads picture files as they are, counts them and what is missing between them. Of
/// the io thread; decoding is not its work.
class CameraIntake {
 public:
  /// A file larger than this is no picture.
  static constexpr size_t kMaxBytes = 64 << 20;

  /// Reads a picture's file into `encoded`, which keeps its memory. False, and counted, where it
  /// cannot be read.
  bool read_image(Stamp stamp, uint64_t sequence, const std::filesystem::path& path,
                  std::vector<uint8_t>& encoded);

  /// Counts a picture, and what is missing before it.
  void count(Stamp stamp, uint64_t sequence);

  const StreamCounters& counters() const { return counters_; }

 private:
  StreamCounters counters_;
  uint64_t next_ = 0;  // sequence that follows the last
};

}  // namespace infuse::daemon
