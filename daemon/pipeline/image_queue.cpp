#include "daemon/pipeline/image_queue.hpp"

namespace infuse::daemon {

ImageQueue::ImageQueue(SlotRing<CameraImage>& images, size_t capacity, Duration timeout)
    : images_(images.make_reader()), capacity_(capacity), timeout_(timeout) {
  waiting_.reserve(capacity);
}

std::optional<CameraIndex> ImageQueue::push(const StreamItem& item) {
  std::optional<CameraIndex> dropped_camera;
  if (waiting_.size() == capacity_) {
    fetch_up_to(0);
    dropped_camera = waiting_.front().camera;
    waiting_.erase(waiting_.begin());
  }
  waiting_.push_back({item.camera, item.stamp, item.number});
  return dropped_camera;
}

// The ring is read in order: fetching an image fetches those before it.
void ImageQueue::fetch_up_to(size_t last) {
  for (size_t i = 0; i <= last; ++i) {
    if (waiting_[i].fetched) continue;
    waiting_[i].image = fetch_number(waiting_[i].number);
    waiting_[i].fetched = true;
  }
}

Pin<CameraImage> ImageQueue::fetch_number(uint64_t number) {
  while (!ahead_ || ahead_->number < number) {
    if (!images_.wait(timeout_)) return {};  // the ring was closed, or the decoder is too slow
    ahead_ = images_.next();
  }
  if (ahead_->number > number) return {};
  return std::move(ahead_);
}

}  // namespace infuse::daemon
