#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::rosbag {

/// A topic as one node published it.
struct Connection {
  std::string topic;
  std::string type;  ///< "sensor_msgs/Imu"
};

/// One message in ROS 1's encoding. Its data is valid until the next message is read, its
/// connection as long as the reader.
struct BagMessage {
  const Connection* connection = nullptr;
  Stamp time;  ///< when it was recorded
  std::span<const uint8_t> data;
};

/// What a file contained besides sound messages.
struct BagCounters {
  uint64_t messages = 0;
  uint64_t damaged_chunks = 0;      ///< skipped: not decompressible, in an unknown compression
  uint64_t damaged_records = 0;     ///< skipped: without the fields of their kind
  uint64_t without_connection = 0;  ///< messages of a connection that is not described
};

/// Reads a bag of ROS 1 (format 2.0) in memory in the order in which it was written: chunks plain,
/// bz2 and lz4, with or without an index, cut anywhere. Memory is bounded by one chunk (256 MiB)
/// and 64 MiB of connections.
class BagReader {
 public:
  /// Opens a file in memory, which must outlive the reader. `name` is that of the file in errors.
  static Result<BagReader> open(std::span<const uint8_t> bytes, const std::string& name);

  /// True if a file begins like a bag.
  static bool is_bag(std::span<const uint8_t> bytes);

  /// Reads the next message. Returns false at the end, or where the file is cut.
  bool next(BagMessage& message);

  /// Counters of the records read so far.
  const BagCounters& counters() const { return counters_; }

  /// Appends what was wrong with the file so far, for display.
  void append_notes(std::vector<Error>& notes) const;

 private:
  BagReader(std::span<const uint8_t> bytes, std::string name)
      : rest_(bytes), size_(bytes.size()), name_(std::move(name)) {}
  bool read_chunk(std::span<const uint8_t> header, std::span<const uint8_t> data);
  bool read_message(std::span<const uint8_t> header, std::span<const uint8_t> data,
                    BagMessage& message);
  void read_connection(std::span<const uint8_t> header, std::span<const uint8_t> data);

  std::span<const uint8_t> rest_;        ///< of the file
  std::span<const uint8_t> chunk_rest_;  ///< of the chunk that is being read
  size_t size_;
  std::string name_;
  std::vector<uint8_t> chunk_;
  std::map<uint32_t, Connection> connections_;
  size_t connection_bytes_ = 0;
  BagCounters counters_;
  std::vector<Error> notes_;
};

}  // namespace infuse::rosbag
