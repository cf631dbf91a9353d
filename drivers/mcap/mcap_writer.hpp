#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/mcap/compression.hpp"
#include "drivers/mcap/mcap_reader.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::mcap {

/// Properties of a file to write.
struct WriterOptions {
  std::string profile = "ros2";
  Compression compression = Compression::kZstd;
  Duration chunk_span{1'000'000'000};    ///< maximum span of the log times in a chunk
  size_t chunk_bytes = size_t{4} << 20;  ///< a chunk ends with the message that reaches this
  bool flush_chunks = false;  ///< give each chunk to the kernel: the end of the process loses none
  /// Returns what is invalid, if anything.
  std::optional<std::string> invalid() const;
};

/// Writes an MCAP file (version 0) in chunks, with message indexes, a summary of schemas, channels,
/// statistics and chunk indexes, and CRCs of all parts. A file that is cut is readable up to its
/// last whole chunk.
class McapWriter {
 public:
  /// Creates or overwrites the file.
  static Result<McapWriter> create(const std::filesystem::path& path,
                                   const WriterOptions& options = {});

  /// Adds a channel and its schema, and returns the channel's id. Equal schemas are stored once.
  /// At most 65535 channels.
  Result<uint16_t> add_channel(const Channel& channel);

  /// Appends a message to a channel of `add_channel`. Stamps before 1970 are errors.
  Result<void> write(uint16_t channel, Stamp log_time, Stamp publish_time,
                     std::span<const uint8_t> data);

  /// Appends a metadata record.
  Result<void> write_metadata(const std::string& name,
                              const std::map<std::string, std::string>& pairs);

  /// Writes the last chunk and the summary, and closes the file. Nothing can be written afterwards.
  Result<void> close();

  uint64_t messages() const { return messages_; }

 private:
  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  struct IndexEntry {
    uint64_t time, offset;
  };
  struct ChunkIndex {
    uint64_t first = 0, last = 0;    ///< log times
    uint64_t start = 0, length = 0;  ///< of the chunk record in the file
    std::map<uint16_t, uint64_t> message_indexes;
    uint64_t message_index_length = 0;
    uint64_t compressed = 0, uncompressed = 0;
  };
  struct MetadataIndex {
    uint64_t offset = 0, length = 0;
    std::string name;
  };
  McapWriter(std::filesystem::path path, WriterOptions options)
      : path_(std::move(path)), options_(std::move(options)) {}
  Result<void> put(std::span<const uint8_t> bytes);
  Result<void> end_chunk();
  Result<void> write_summary();
  static void add_schema_record(uint16_t id, const Schema& schema, std::vector<uint8_t>& bytes);
  static void add_channel_record(uint16_t id, uint16_t schema, const Channel& channel,
                                 std::vector<uint8_t>& bytes);
  void add_statistics(std::vector<uint8_t>& bytes) const;
  void add_chunk_indexes(std::vector<uint8_t>& bytes) const;

  std::filesystem::path path_;
  WriterOptions options_;
  std::unique_ptr<std::FILE, CloseFile> file_;
  uint64_t position_ = 0;        ///< bytes written
  uint32_t data_crc_ = 0;        ///< of these
  std::vector<Schema> schemas_;  ///< schema k has the id k + 1
  struct WrittenChannel {
    Channel channel;
    uint16_t schema = 0;
    uint64_t messages = 0;
  };
  std::vector<WrittenChannel> channels_;
  std::vector<uint8_t> chunk_, compressed_, record_;
  ChunkIndex current_;
  std::map<uint16_t, std::vector<IndexEntry>> entries_;  ///< of the current chunk
  std::vector<ChunkIndex> chunks_;
  std::vector<MetadataIndex> metadata_;
  uint64_t messages_ = 0, first_ = 0, last_ = 0;
};

}  // namespace infuse::mcap
