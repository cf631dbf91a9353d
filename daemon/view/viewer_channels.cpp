#include "daemon/view/viewer_channels.hpp"

namespace infuse::daemon {

ViewerChannels::ViewerChannels(const MessageSetup& setup)
    : replay_(!setup.live), topics_(list_topics(setup)), viewers_(topics_.size()) {
  for (size_t k = 0; k < topics_.size(); ++k)
    channels_[topics_[k].topic] = static_cast<uint32_t>(k);
}

void ViewerChannels::subscribe(uint32_t channel) {
  ++viewers_[channel];
  ++subscriptions_;
  on_change_();
}

void ViewerChannels::unsubscribe(uint32_t channel) {
  --viewers_[channel];
  --subscriptions_;
  on_change_();
}

ViewerChannels::Message ViewerChannels::latched(uint32_t channel) const {
  const std::lock_guard lock(mutex_);
  const auto found = latched_.find(channel);
  return found == latched_.end() ? nullptr : found->second;
}

bool ViewerChannels::wants(const std::string& topic) const {
  const auto found = channels_.find(topic);
  if (found == channels_.end()) return false;
  return topics_[found->second].latched || viewers_[found->second].load() > 0;
}

void ViewerChannels::add(const std::string& topic, const char*, Stamp log_time, bool latched,
                         std::span<const uint8_t> bytes) {
  const auto found = channels_.find(topic);
  if (found == channels_.end()) return;
  const auto message = std::make_shared<const ViewerMessage>(
      ViewerMessage{found->second, log_time, std::vector<uint8_t>(bytes.begin(), bytes.end())});
  if (latched) {
    const std::lock_guard lock(mutex_);
    latched_[message->channel] = message;
  }
  if (viewers_[message->channel].load() > 0) on_message_(message);
}

}  // namespace infuse::daemon
