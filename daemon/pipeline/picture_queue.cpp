#include "daemon/pipeline/picture_queue.hpp"

namespace infuse::daemon {

PictureQueue::PictureQueue(SlotRing<Picture>& pictures, size_t capacity, Duration patience)
    : pictures_(pictures.reader()), capacity_(capacity), patience_(patience) {
  waiting_.reserve(capacity);
}

std::optional<uint32_t> PictureQueue::expect(const StreamItem& item) {
  std::optional<uint32_t> given_up;
  if (waiting_.size() == capacity_) {
    fetch(0);
    given_up = waiting_.front().camera;
    waiting_.erase(waiting_.begin());
  }
  waiting_.push_back({item.camera, item.stamp, item.number});
  return given_up;
}

// The ring is read in order: who wants a picture takes those before it too.
void PictureQueue::fetch(size_t last) {
  for (size_t i = 0; i <= last; ++i) {
    if (waiting_[i].fetched) continue;
    waiting_[i].picture = fetch_number(waiting_[i].number);
    waiting_[i].fetched = true;
  }
}

Pin<Picture> PictureQueue::fetch_number(uint64_t number) {
  while (!ahead_ || ahead_->number < number) {
    if (!pictures_.wait(patience_)) return {};  // the ring was closed, or the decoder is too slow
    ahead_ = pictures_.next();
  }
  if (ahead_->number > number) return {};
  return std::move(ahead_);
}

}  // namespace infuse::daemon
