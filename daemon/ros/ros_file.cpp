#include "daemon/ros/ros_file.hpp"

#include "drivers/ros/schemas.hpp"

namespace infuse::daemon {
namespace {

/// As rosbag2 of ROS 2 Humble writes it: keep the last ten (or the one) messages, reliable.
std::string quality_of_service(bool latched) {
  const std::string forever = "    sec: 9223372036\n    nsec: 854775807\n";
  return std::string("- history: 1\n  depth: ") + (latched ? "1" : "10") +
         "\n  reliability: 1\n  durability: " + (latched ? "1" : "2") + "\n  deadline:\n" +
         forever + "  lifespan:\n" + forever + "  liveliness: 1\n  liveliness_lease_duration:\n" +
         forever + "  avoid_ros_namespace_conventions: false";
}

}  // namespace

Result<RosFile> RosFile::create(const std::filesystem::path& path,
                                const mcap::WriterOptions& options) {
  auto writer = mcap::McapWriter::create(path, options);
  if (!writer) return tl::unexpected(writer.error());
  return RosFile(std::move(*writer));
}

void RosFile::keep_error(const Result<void>& result) {
  if (!result && !error_) error_ = result.error();
}

void RosFile::add(const std::string& topic, const char* type, Stamp log_time, bool latched,
                  std::span<const uint8_t> bytes) {
  if (error_) return;
  auto channel = channels_.find(topic);
  if (channel == channels_.end()) {
    const auto added =
        writer_.add_channel({topic,
                             "cdr",
                             {type, "ros2msg", ros::schema_of(type).value_or("")},
                             {{"offered_qos_profiles", quality_of_service(latched)}}});
    if (!added) {
      error_ = added.error();
      return;
    }
    channel = channels_.emplace(topic, *added).first;
  }
  keep_error(writer_.write(channel->second, log_time, log_time, bytes));
  ++messages_[topic];
}

void RosFile::write_metadata(const std::map<std::string, std::string>& pairs) {
  if (!error_) keep_error(writer_.write_metadata("infuse", pairs));
}

Result<void> RosFile::close() {
  keep_error(writer_.close());
  if (error_) return tl::unexpected(*error_);
  return {};
}

}  // namespace infuse::daemon
