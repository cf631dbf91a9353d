#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "daemon/pipeline/image_thread.hpp"
#include "drivers/measurement/slot_ring.hpp"

namespace infuse::daemon {

/// The pictures that wait for the sweep during which they were exposed. Of the fusion thread.
///
/// Which picture is taken when depends on the order of the stream alone: a picture that the decoder
/// has not finished is waited for when it is needed, not before.
class ImageQueue {
 public:
  /// Holds at most `capacity` pictures, the ring's or fewer. Registers as a reader of `pictures`.
  /// A picture that the decoder has not finished is waited for as long as `patience`.
  ImageQueue(SlotRing<CameraImage>& images, size_t capacity, Duration timeout);

  /// A picture was handed over; the decoder has it. Where the queue is full, the oldest is given
  /// up: then its camera is returned.
  std::optional<uint32_t> push(const StreamItem& item);

  /// Calls `use(const Picture&)` for every waiting picture that `due(camera, stamp)`, in order, and
  /// lets it go.
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
    uint32_t camera = 0;
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
  Pin<CameraImage> ahead_;  // read from the ring, but of a later number than was requested
};

}  // namespace infuse::daemon
