#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "daemon/ros/message_sink.hpp"
#include "daemon/ros/topics.hpp"

namespace infuse::daemon {

/// A message of a channel, shared by all viewers that get it.
struct ViewerMessage {
  uint32_t channel = 0;
  Stamp log_time;
  std::vector<uint8_t> payload;
};

/// The topics that viewers (Foxglove) may subscribe to, and who passes messages on to them. Nothing
/// is made of a topic to which nobody has subscribed, but what is latched.
class ViewerChannels : public MessageSink {
 public:
  using Message = std::shared_ptr<const ViewerMessage>;

  explicit ViewerChannels(const MessageSetup& setup);

  const std::vector<TopicInfo>& topics() const { return topics_; }
  bool is_replay() const { return replay_; }

  /// Sets who passes messages on, and who is informed of changed subscriptions; before the start
  /// of the stream.
  void on_message(std::function<void(Message)> listener) { on_message_ = std::move(listener); }
  void on_change(std::function<void()> listener) { on_change_ = std::move(listener); }

  /// Adds or removes a viewer of a channel that exists. From any thread.
  void subscribe(uint32_t channel);
  void unsubscribe(uint32_t channel);
  /// True if there are viewers.
  bool wanted() const { return subscriptions_.load() > 0; }

  /// The latched message of a channel; null if there is none.
  Message latched(uint32_t channel) const;

  bool wants(const std::string& topic) const override;
  void add(const std::string& topic, const char* type, Stamp log_time, bool latched,
           std::span<const uint8_t> bytes) override;

 private:
  const bool replay_;
  std::vector<TopicInfo> topics_;
  std::map<std::string, uint32_t> channels_;    // by topic
  std::vector<std::atomic<uint32_t>> viewers_;  // by channel
  std::atomic<uint32_t> subscriptions_{0};
  std::function<void(Message)> on_message_ = [](const Message&) {};
  std::function<void()> on_change_ = [] {};
  mutable std::mutex mutex_;
  std::map<uint32_t, Message> latched_;
};

}  // namespace infuse::daemon
