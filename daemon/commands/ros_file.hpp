#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "drivers/mcap/mcap_writer.hpp"
#include "drivers/ros/schemas.hpp"
#include "drivers/ros/serialisation.hpp"

namespace infuse::daemon {

/// An MCAP file of ROS 2 messages as rosbag2 writes it: profile ros2, CDR, the schema and the
/// quality of service of each topic. The first error ends it.
class RosFile {
 public:
  static Result<RosFile> create(const std::filesystem::path& path);

  /// Appends a message; the first one of a topic creates it. `latched`: a subscriber that comes
  /// later receives it too (transient local).
  template <class T>
  void write(const std::string& topic, Stamp log_time, const T& message, bool latched = false) {
    if (error_) return;
    ros::encode(message, ros::Encoding::kCdr, bytes_);
    write_bytes(topic, T::kName, log_time, latched);
  }
  void write_metadata(const std::map<std::string, std::string>& pairs);

  /// Writes index and summary. Returns the first error of all calls.
  Result<void> close();

  /// Number of messages of each topic.
  const std::map<std::string, size_t>& messages() const { return messages_; }
  bool failed() const { return error_.has_value(); }

 private:
  explicit RosFile(mcap::McapWriter writer) : writer_(std::move(writer)) {}
  void write_bytes(const std::string& topic, const char* type, Stamp log_time, bool latched);
  void keep_error(const Result<void>& result);

  mcap::McapWriter writer_;
  std::map<std::string, uint16_t> channels_;
  std::map<std::string, size_t> messages_;
  std::vector<uint8_t> bytes_;
  std::optional<Error> error_;
};

}  // namespace infuse::daemon
