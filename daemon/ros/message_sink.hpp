#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "drivers/measurement/stamp.hpp"
#include "drivers/ros/serialisation.hpp"

namespace infuse::daemon {

/// Where messages on topics go, as CDR. For one thread, but `wants`.
class MessageSink {
 public:
  /// Streams that run side by side; each is in order, and ends its seconds of drive time.
  enum class Lane : uint8_t { kSensors, kSweeps, kReports };
  static constexpr size_t kLanes = 3;

  MessageSink() = default;
  MessageSink(const MessageSink&) = default;
  MessageSink(MessageSink&&) = default;
  MessageSink& operator=(const MessageSink&) = default;
  MessageSink& operator=(MessageSink&&) = default;
  virtual ~MessageSink() = default;

  /// True if messages of the topic are of use now. From any thread.
  virtual bool wants(const std::string& topic) const = 0;

  /// Adds a message, encoded. `latched`: whoever comes later receives it too (transient local).
  virtual void add(const std::string& topic, const char* type, Stamp log_time, bool latched,
                   std::span<const uint8_t> bytes) = 0;

  /// The messages that follow are of this lane.
  virtual void begin_lane(Lane) {}
  /// The lane has passed a second of drive time.
  virtual void end_second() {}

  /// Encodes and adds a message, if its topic is wanted.
  template <class T>
  void write(const std::string& topic, Stamp log_time, const T& message, bool latched = false) {
    if (!wants(topic)) return;
    ros::encode(message, ros::Encoding::kCdr, encoded_);
    add(topic, T::kName, log_time, latched, encoded_);
  }

 private:
  std::vector<uint8_t> encoded_;
};

}  // namespace infuse::daemon
