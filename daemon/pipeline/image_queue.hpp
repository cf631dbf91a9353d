#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "daemon/pipeline/image_thread.hpp"
#include "drivers/measurement/slot_ring.hpp"

namespace infuse::daemon {

/// Images that wait for the sweep during which they were exposed. Used on the fusion thread.
///
/// The order of images depends on the order of the stream alone: an image that is not decoded yet
/// is waited for when it is needed.
class ImageQueue {
 public:
  /// Holds at most `capacity` images, the ring's capacity or less. Registers as a reader of
  /// `images`. `timeout`: maximum wait for the decoder.
  ImageQueue(SlotRing<CameraImage>& images, size_t capacity, Duration timeout);

  /// Adds an image that the decoder receives too. If the queue is full, drops the oldest and
  /// returns its camera.
  std::optional<CameraIndex> push(const StreamItem& item);

  /// Calls `use(const CameraImage&)` for every waiting image with `due(CameraIndex, Stamp)`, in
  /// order, and removes it.
  template <class Due, class Use>
  void pop_due(Due due, Use use) {
    size_t kept = 0;
    for (size_t i = 0; i < waiting_.size(); ++i) {
      if (due(waiting_[i].camera, waiting_[i].stamp)) {
        fetch_up_to(i);
        if (waiting_[i].image) use(*waiting_[i].image);
        waiting_[i].image.reset();
      } else {
        if (kept != i) waiting_[kept] = std::move(waiting_[i]);
        ++kept;
      }
    }
    waiting_.resize(kept);
  }

 private:
  struct Entry {
    CameraIndex camera;
    Stamp stamp;
    uint64_t number = 0;
    bool fetched = false;
    Pin<CameraImage> image = {};
  };

  void fetch_up_to(size_t last);
  Pin<CameraImage> fetch_number(uint64_t number);

  SlotRing<CameraImage>::Reader images_;
  size_t capacity_;
  Duration timeout_;
  std::vector<Entry> waiting_;
  Pin<CameraImage> ahead_;  // read from the ring, with a later number than requested
};

}  // namespace infuse::daemon
