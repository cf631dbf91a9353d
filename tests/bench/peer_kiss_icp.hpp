#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

namespace infuse::bench {

/// KISS-ICP with its default settings on one thread, behind an interface without its types: it is
/// compiled for this processor, in a library of its own.
class [[gnu::visibility("default")]] PeerKissIcp {
 public:
  explicit PeerKissIcp(bool deskew);
  ~PeerKissIcp();

  /// Sets the returns of the next sweep: coordinates in the lidar frame, m, and times, ns after any
  /// origin.
  void set_points(const float* x, const float* y, const float* z, const int32_t* time_ns,
                  size_t size);
  /// Registers that sweep. `T_first_lidar`, 4 × 4 by column: pose of the lidar at the last return,
  /// or without deskewing about the middle of the sweep.
  void add(double* T_first_lidar);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace infuse::bench
