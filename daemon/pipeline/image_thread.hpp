#pragma once

#include <cstdint>
#include <vector>

#include "daemon/health/latency_histogram.hpp"
#include "daemon/pipeline/delivery.hpp"
#include "daemon/pipeline/stream_item.hpp"
#include "drivers/camera/image_decoder.hpp"
#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/slot_ring.hpp"

namespace infuse::daemon {

/// A decoded image.
struct CameraImage {
  Stamp stamp;              ///< middle of the exposure
  CameraIndex camera;       ///< index in the rig
  uint64_t number = 0;      ///< number of its StreamItem
  bool readable = false;    ///< false: damaged, `frame` is invalid
  CameraFrame frame;        ///< decoded
  Duration decode_time{0};  ///< host time of decoding
};

/// The image thread: decodes images. Every item of kind kImage becomes one `CameraImage`, in order.
class ImageThread {
 public:
  /// Registers as a reader of `in`. The rings outlive this.
  ImageThread(SlotRing<StreamItem>& in, SlotRing<CameraImage>& out, const SensorSetup& setup);

  /// Runs until the item kEnd, or `in` is closed.
  void run();

 private:
  void decode(const StreamItem& item, CameraImage& image) const;
  Result<void> unpack(const StreamItem& item, CameraFrame& frame) const;

  SlotRing<StreamItem>::Reader in_;
  SlotRing<CameraImage>& out_;
  std::vector<camera::ImageOptions> options_;  // by CameraIndex
  Delivery delivery_;
};

}  // namespace infuse::daemon
