#pragma once

#include <map>
#include <string>
#include <vector>

#include "drivers/mcap/mcap_writer.hpp"
#include "drivers/ros/messages.hpp"
#include "drivers/ros/serialisation.hpp"

namespace infuse::importers {

/// Writes messages to an MCAP file as a recorder does.
class BagFile {
 public:
  explicit BagFile(const std::filesystem::path& path,
                   mcap::Compression compression = mcap::Compression::kNone)
      : writer_(*mcap::McapWriter::create(path, {.compression = compression})) {}

  template <class T>
  void write(const std::string& topic, int64_t log_ns, const T& message) {
    if (!channels_.contains(topic))
      channels_[topic] = *writer_.add_channel({topic, "cdr", {T::kName, "ros2msg", ""}, {}});
    std::vector<uint8_t> bytes;
    ros::encode(message, ros::Encoding::kCdr, bytes);
    const Stamp stamp = Stamp::from_ns(log_ns);
    static_cast<void>(writer_.write(channels_[topic], stamp, stamp, bytes));
  }
  void write_metadata(const std::string& name, const std::map<std::string, std::string>& pairs) {
    static_cast<void>(writer_.write_metadata(name, pairs));
  }
  void close() { static_cast<void>(writer_.close()); }

 private:
  mcap::McapWriter writer_;
  std::map<std::string, uint16_t> channels_;
};

inline ros::Header make_header(int64_t ns, const std::string& frame) {
  return {0, ros::Time::from(Stamp::from_ns(ns)), frame};
}

/// T_parent_child as a message.
inline ros::TfMessage make_transform(const std::string& parent, const std::string& child, double x,
                                     double y = 0, double z = 0) {
  return {{{make_header(1, parent), child, {{x, y, z}, {0, 0, 0, 1}}}}};
}

inline ros::CameraInfo make_info(uint32_t width, uint32_t height) {
  ros::CameraInfo info{.header = make_header(1, "camera"), .height = height, .width = width};
  info.distortion_model = "plumb_bob";
  info.d = {0.1, 0.2, 0.3, 0.4, 0.5};
  info.k = {400, 0, 320, 0, 410, 240, 0, 0, 1};
  info.p = {300, 0, 310, 0, 0, 310, 230, 0, 0, 0, 1, 0};
  return info;
}

}  // namespace infuse::importers
