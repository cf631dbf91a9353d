#pragma once

#include "daemon/pipeline/image_match.hpp"
#include "daemon/setup/sensor_id.hpp"

namespace infuse::daemon {

/// Somebody who gets copies of what passes through the pipeline, besides reading its ring of items.
/// Called on the threads of the pipeline: must not wait for anything slow.
class PipelineTap {
 public:
  PipelineTap() = default;
  PipelineTap(const PipelineTap&) = delete;
  PipelineTap& operator=(const PipelineTap&) = delete;
  virtual ~PipelineTap() = default;

  /// On the io thread: whether the datagrams of the lidar are passed on as they are, in items of
  /// kind kDatagrams.
  virtual bool wants_datagrams(LidarIndex lidar) const = 0;

  /// On the fusion thread: a sweep as of its end.
  virtual void add_sweep(const SweepSnapshot& snapshot) = 0;

  /// On the fusion thread: a second of drive time has passed.
  virtual void end_second() = 0;
};

}  // namespace infuse::daemon
