#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::mcap {

/// Definition of a message type.
struct Schema {
  std::string name;      ///< "sensor_msgs/msg/Imu"
  std::string encoding;  ///< "ros2msg"
  std::string text;
  bool operator==(const Schema&) const = default;
};

/// A stream of messages of one type.
struct Channel {
  std::string topic;
  std::string encoding;  ///< of its messages: "cdr"
  Schema schema;         ///< empty if the messages have none
  std::map<std::string, std::string> metadata;
  bool operator==(const Channel&) const = default;
};

/// One message. Its data is valid until the next message is read, its channel as long as the
/// reader.
struct Message {
  uint16_t channel_id = 0;
  const Channel* channel = nullptr;
  uint32_t sequence = 0;
  Stamp log_time;
  Stamp publish_time;
  std::span<const uint8_t> data;
};

/// What a file contained besides sound messages.
struct ReaderCounters {
  uint64_t messages = 0;
  uint64_t chunks = 0;
  uint64_t damaged_chunks = 0;   ///< skipped: wrong CRC, not decompressible
  uint64_t damaged_records = 0;  ///< skipped: shorter than their fields
  uint64_t without_channel = 0;  ///< messages of a channel that is not described
  uint64_t unknown_records = 0;  ///< skipped: of a kind that this reader does not know
  uint64_t attachments = 0;      ///< attachments: not read
};

/// Reads an MCAP file (version 0) in memory in the order in which it was written: chunks plain, lz4
/// and zstd, with or without an index, cut anywhere. CRCs are checked where they are present.
/// Memory is bounded by one chunk and 64 MiB of schemas.
class McapReader {
 public:
  /// Opens a file in memory, which must outlive the reader. `name` is that of the file in errors.
  static Result<McapReader> open(std::span<const uint8_t> bytes, const std::string& name);

  /// Reads the next message. Returns false at the end of the messages, or where the file is cut.
  bool next(Message& message);

  /// Text pairs of the metadata records read so far, by name.
  const std::map<std::string, std::map<std::string, std::string>>& metadata() const {
    return metadata_;
  }
  /// Counters of the records read so far.
  const ReaderCounters& counters() const { return counters_; }

  /// True if the file ends as it should: with an end of its data, summary and magic.
  bool is_complete() const { return complete_; }

  /// Appends what was wrong with the file so far, for display.
  void append_notes(std::vector<Error>& notes) const;

 private:
  struct Record {
    uint8_t opcode = 0;
    std::span<const uint8_t> content;
  };
  McapReader(std::span<const uint8_t> bytes, std::string name)
      : bytes_(bytes), name_(std::move(name)) {}
  static std::optional<Record> split_record(std::span<const uint8_t>& rest);
  bool read_record(const Record& record, bool in_chunk, size_t position, Message& message);
  bool read_chunk(std::span<const uint8_t> content);
  bool read_message(std::span<const uint8_t> content, Message& message);
  void read_schema(std::span<const uint8_t> content);
  void read_channel(std::span<const uint8_t> content);
  void read_metadata(std::span<const uint8_t> content);
  bool keep_text(size_t bytes);
  void read_summary();
  void end_data(std::span<const uint8_t> content, size_t data_bytes);
  void note(std::string what, std::string hint = {});

  std::span<const uint8_t> bytes_;
  std::string name_;
  std::span<const uint8_t> rest_;        ///< of the file
  std::span<const uint8_t> chunk_rest_;  ///< of the chunk that is being read
  std::vector<uint8_t> chunk_;
  std::map<uint16_t, Schema> schemas_;
  std::map<uint16_t, Channel> channels_;
  std::map<std::string, std::map<std::string, std::string>> metadata_;
  size_t text_bytes_ = 0;
  ReaderCounters counters_;
  std::vector<Error> notes_;
  bool complete_ = false;
};

}  // namespace infuse::mcap
