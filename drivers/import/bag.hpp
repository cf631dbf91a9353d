#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"
#include "drivers/ros/messages.hpp"
#include "drivers/ros/serialisation.hpp"

namespace infuse::importers {

/// A message of a recording of ROS. Valid until the next one is read.
struct BagMessage {
  std::string_view topic;
  std::string_view type;  ///< in ROS 2's form: "sensor_msgs/msg/Imu"; empty if unknown
  ros::Encoding encoding = ros::Encoding::kCdr;
  Stamp log_time;
  std::span<const uint8_t> data;
};

/// Stamp of a message: of its header, or its log time if that has none.
Stamp stamp_of(const ros::Header& header, Stamp log_time);

/// A recording of ROS, read from its begin to its end.
class Bag {
 public:
  virtual ~Bag() = default;

  /// Reads the next message in the order of the file. Returns false at the end.
  virtual bool next(BagMessage& message) = 0;

  /// Text pairs that the file states by name, as far as it has been read.
  virtual std::map<std::string, std::map<std::string, std::string>> metadata() const { return {}; }

  /// Appends what was wrong with the file so far.
  virtual void append_notes(std::vector<Error>& notes) const = 0;
};

/// Opens a file: MCAP or a database of rosbag2 with messages in CDR or in ROS 1's encoding, or a
/// bag of ROS 1. Messages in other encodings are skipped and noted. The error names the formats
/// that are known.
Result<std::unique_ptr<Bag>> open_bag(const std::filesystem::path& path);

/// Returns the files to read: a folder stands for the .mcap, .db3 and .bag files in it, by number
/// (a_2 before a_10). Fails if a folder has none.
Result<std::vector<std::filesystem::path>> list_bags(
    const std::vector<std::filesystem::path>& paths);

}  // namespace infuse::importers
