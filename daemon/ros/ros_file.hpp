#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "daemon/ros/message_sink.hpp"
#include "drivers/mcap/mcap_writer.hpp"

namespace infuse::daemon {

/// An MCAP file of ROS 2 messages as rosbag2 writes it: profile ros2, CDR, the schema and the
/// quality of service of each topic. The first message of a topic creates it. The first error ends
/// the file.
class RosFile : public MessageSink {
 public:
  static Result<RosFile> create(const std::filesystem::path& path,
                                const mcap::WriterOptions& options = {});

  bool wants(const std::string&) const override { return !error_.has_value(); }
  void add(const std::string& topic, const char* type, Stamp log_time, bool latched,
           std::span<const uint8_t> bytes) override;
  void write_metadata(const std::map<std::string, std::string>& pairs);

  /// Writes index and summary. Returns the first error of all calls.
  Result<void> close();

  /// Number of messages of each topic.
  const std::map<std::string, size_t>& messages() const { return messages_; }
  /// The first error; nothing if there is none.
  const std::optional<Error>& error() const { return error_; }
  bool failed() const { return error_.has_value(); }

 private:
  explicit RosFile(mcap::McapWriter writer) : writer_(std::move(writer)) {}
  void keep_error(const Result<void>& result);

  mcap::McapWriter writer_;
  std::map<std::string, uint16_t> channels_;
  std::map<std::string, size_t> messages_;
  std::optional<Error> error_;
};

}  // namespace infuse::daemon
