#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "daemon/config/lcm_settings.hpp"
#include "daemon/ros/message_setup.hpp"
#include "daemon/ros/message_sink.hpp"

namespace infuse::daemon {

/// Publishes poses, sweeps and alerts on LCM channels (drivers/lcm/infuse.lcm), from the messages
/// of ROS on their topics. Never waits; what cannot be sent is counted, and said once.
class LcmPublisher : public MessageSink {
 public:
  /// Errors: the socket cannot be opened.
  static Result<std::unique_ptr<LcmPublisher>> create(const LcmSettings& settings,
                                                      const MessageSetup& setup);

  bool wants(const std::string& topic) const override { return topics_.contains(topic); }
  void add(const std::string& topic, const char* type, Stamp log_time, bool latched,
           std::span<const uint8_t> bytes) override;

  /// Numbers of messages sent, and of those that could not be.
  uint64_t sent() const { return sent_; }
  uint64_t failed() const { return failed_; }

 private:
  enum class Kind { kPose, kSweep, kAlert };
  struct Output {
    Kind kind = Kind::kPose;
    std::string channel;
    std::string name;  ///< of the lidar
  };
  LcmPublisher(lcm::LcmSender sender, const LcmSettings& settings, const MessageSetup& setup);
  void add_pose(const Output& output, std::span<const uint8_t> bytes);
  void add_sweep(const Output& output, std::span<const uint8_t> bytes);
  void add_alerts(const Output& output, std::span<const uint8_t> bytes);
  template <class Message>
  void send(const std::string& channel, const Message& message);

  lcm::LcmSender sender_;
  const size_t max_points_;
  std::map<std::string, Output> topics_;
  std::vector<uint8_t> payload_;
  uint64_t sent_ = 0, failed_ = 0;
  bool said_ = false;
};

}  // namespace infuse::daemon
