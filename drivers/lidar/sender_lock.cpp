#include "drivers/lidar/sender_lock.hpp"

#include <algorithm>

namespace infuse::lidar {

bool SenderLock::accept(uint32_t sender, Stamp stamp) {
  if (configured_) return sender == sender_;
  if (sender_ == 0) take(sender, stamp);
  if (stamp < window_start_) {  // time stepped back
    start_window(stamp);
    last_packet_ = stamp;
  }
  if (stamp - window_start_ >= kWindow) end_window(stamp);
  if (sender != sender_) {
    count_other(sender);
    if (stamp - last_packet_ < kSilence) return false;
    take(rival_ != 0 ? rival_ : sender, stamp);
  }
  if (sender != sender_) return false;
  last_packet_ = stamp;
  ++packets_;
  return true;
}

void SenderLock::count_other(uint32_t sender) {
  Candidate* empty = nullptr;
  for (Candidate& other : others_) {
    if (other.packets > 0 && other.sender == sender) {
      ++other.packets;
      return;
    }
    if (other.packets == 0) empty = &other;
  }
  if (empty != nullptr) {
    *empty = {sender, 1};
    return;
  }
  for (Candidate& other : others_) --other.packets;
}

void SenderLock::end_window(Stamp stamp) {
  const double needed = kSensorPacketsHz * to_seconds(stamp - window_start_);
  const Candidate& most = *std::max_element(
      others_.begin(), others_.end(),
      [](const Candidate& a, const Candidate& b) { return a.packets < b.packets; });
  rival_ = most.packets >= needed ? most.sender : 0;
  if (rival_ != 0 && static_cast<double>(packets_) < needed) take(rival_, stamp);
  start_window(stamp);
}

void SenderLock::take(uint32_t sender, Stamp stamp) {
  if (sender_ != 0) ++changes_;
  previous_ = sender_;
  sender_ = sender;
  rival_ = 0;
  last_packet_ = stamp;
  start_window(stamp);
}

void SenderLock::start_window(Stamp stamp) {
  window_start_ = stamp;
  packets_ = 0;
  others_.fill({});
}

}  // namespace infuse::lidar
