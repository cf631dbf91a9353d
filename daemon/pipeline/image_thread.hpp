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

/// A picture as fusion gets it.
struct CameraImage {
  Stamp stamp;              ///< middle of the exposure
  uint32_t camera = 0;      ///< index in the rig
  uint64_t number = 0;      ///< the item's
  bool readable = false;    ///< false: the file is damaged, and `frame` means nothing
  CameraFrame frame;        ///< decoded
  Duration decode_time{0};  ///< host time that decoding took
};

/// Decodes pictures on a thread of its own, neither the io thread's nor the fusion thread's. Every
/// item of kind kImage becomes one `Picture`, in order.
class ImageThread {
 public:
  /// Registers as a reader of `in`. `options`: by camera. The rings outlive this.
  ImageThread(SlotRing<StreamItem>& in, SlotRing<CameraImage>& out,
              std::vector<camera::ImageOptions> options, Delivery delivery);

  /// Until the item kEnd.
  void run();

 private:
  void decode(const StreamItem& item, CameraImage& image) const;
  Result<void> unpack(const StreamItem& item, CameraFrame& frame) const;

  SlotRing<StreamItem>::Reader in_;
  SlotRing<CameraImage>& out_;
  std::vector<camera::ImageOptions> options_;
  Delivery delivery_;
};

}  // namespace infuse::daemon
