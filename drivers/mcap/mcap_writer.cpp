#include "drivers/mcap/mcap_writer.hpp"

#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>

#include "drivers/mcap/record_bytes.hpp"

namespace infuse::mcap {
namespace {

uint32_t crc_after(uint32_t crc, std::span<const uint8_t> bytes) {
  return static_cast<uint32_t>(crc32_z(crc, bytes.data(), bytes.size()));
}

}  // namespace

std::optional<std::string> WriterOptions::invalid() const {
  if (chunk_span <= Duration::zero()) return "chunk_span must be positive";
  if (chunk_bytes == 0 || chunk_bytes > kMaxChunkBytes / 2)
    return "chunk_bytes must be between 1 and 134217728";
  return std::nullopt;
}

Result<McapWriter> McapWriter::create(const std::filesystem::path& path,
                                      const WriterOptions& options) {
  if (const auto wrong = options.invalid()) return fail(*wrong, path.string());
  McapWriter writer(path, options);
  writer.file_.reset(std::fopen(path.c_str(), "wbe"));
  if (!writer.file_) {
    return fail(std::string("cannot be created: ") + std::strerror(errno), path.string());
  }
  std::vector<uint8_t> bytes;
  FieldWriter fields(bytes);
  fields.raw(kMagic);
  const size_t header = fields.begin_record(Opcode::kHeader);
  fields.text(options.profile);
  fields.text("infuse");
  fields.end_record(header);
  if (auto written = writer.put(bytes); !written) return tl::unexpected(written.error());
  return writer;
}

Result<void> McapWriter::put(std::span<const uint8_t> bytes) {
  if (!file_) return fail("is closed", path_.string());
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) {
    return fail(std::string("cannot be written: ") + std::strerror(errno), path_.string());
  }
  data_crc_ = crc_after(data_crc_, bytes);
  position_ += bytes.size();
  return {};
}

void McapWriter::add_schema_record(uint16_t id, const Schema& schema, std::vector<uint8_t>& bytes) {
  FieldWriter fields(bytes);
  const size_t record = fields.begin_record(Opcode::kSchema);
  fields.number(id);
  fields.text(schema.name);
  fields.text(schema.encoding);
  fields.text(schema.text);
  fields.end_record(record);
}

void McapWriter::add_channel_record(uint16_t id, uint16_t schema, const Channel& channel,
                                    std::vector<uint8_t>& bytes) {
  FieldWriter fields(bytes);
  const size_t record = fields.begin_record(Opcode::kChannel);
  fields.number(id);
  fields.number(schema);
  fields.text(channel.topic);
  fields.text(channel.encoding);
  fields.pairs(channel.metadata);
  fields.end_record(record);
}

// Schemas and channels are written before the chunks that use them, outside: a reader that skips a
// damaged chunk still knows them.
Result<uint16_t> McapWriter::add_channel(const Channel& channel) {
  constexpr size_t kMaxIds = std::numeric_limits<uint16_t>::max();
  if (channels_.size() >= kMaxIds) return fail("has too many channels", path_.string());
  record_.clear();
  uint16_t schema = 0;
  if (channel.schema != Schema{}) {
    const auto found = std::find(schemas_.begin(), schemas_.end(), channel.schema);
    schema = static_cast<uint16_t>(found - schemas_.begin() + 1);
    if (found == schemas_.end()) {
      schemas_.push_back(channel.schema);
      add_schema_record(schema, channel.schema, record_);
    }
  }
  const auto id = static_cast<uint16_t>(channels_.size());
  channels_.push_back({channel, schema});
  add_channel_record(id, schema, channel, record_);
  if (auto written = put(record_); !written) return tl::unexpected(written.error());
  return id;
}

Result<void> McapWriter::write(uint16_t channel, Stamp log_time, Stamp publish_time,
                               std::span<const uint8_t> data) {
  if (channel >= channels_.size()) return fail("has no such channel", path_.string());
  if (log_time.ns() < 0 || publish_time.ns() < 0) {
    return fail("cannot contain stamps before 1970", path_.string());
  }
  if (data.size() > kMaxChunkBytes / 2) {
    return fail("cannot contain a message of more than 128 MiB", path_.string());
  }
  const auto time = static_cast<uint64_t>(log_time.ns());
  const auto span = static_cast<uint64_t>(options_.chunk_span.count());
  if (!chunk_.empty() && std::max(current_.last, time) - std::min(current_.first, time) > span) {
    if (auto ended = end_chunk(); !ended) return ended;
  }
  if (chunk_.empty()) current_.first = current_.last = time;
  current_.first = std::min(current_.first, time);
  current_.last = std::max(current_.last, time);
  entries_[channel].push_back({time, chunk_.size()});
  FieldWriter fields(chunk_);
  const size_t record = fields.begin_record(Opcode::kMessage);
  fields.number(channel);
  fields.number(static_cast<uint32_t>(channels_[channel].messages));
  fields.number(time);
  fields.number(static_cast<uint64_t>(publish_time.ns()));
  fields.raw(data);
  fields.end_record(record);
  ++channels_[channel].messages;
  first_ = messages_ == 0 ? time : std::min(first_, time);
  last_ = std::max(last_, time);
  ++messages_;
  return chunk_.size() >= options_.chunk_bytes ? end_chunk() : Result<void>{};
}

Result<void> McapWriter::end_chunk() {
  if (chunk_.empty()) return {};
  if (auto done = compress_chunk(options_.compression, chunk_, compressed_); !done) return done;
  record_.clear();
  FieldWriter fields(record_);
  const size_t chunk = fields.begin_record(Opcode::kChunk);
  fields.number(current_.first);
  fields.number(current_.last);
  fields.number(static_cast<uint64_t>(chunk_.size()));
  fields.number(crc_after(0, chunk_));
  fields.text(name_of(options_.compression));
  fields.number(static_cast<uint64_t>(compressed_.size()));
  fields.raw(compressed_);
  fields.end_record(chunk);
  current_.start = position_;
  current_.length = record_.size();
  current_.compressed = compressed_.size();
  current_.uncompressed = chunk_.size();
  for (const auto& [channel, entries] : entries_) {
    current_.message_indexes[channel] = position_ + record_.size();
    const size_t index = fields.begin_record(Opcode::kMessageIndex);
    fields.number(channel);
    fields.number(static_cast<uint32_t>(entries.size() * sizeof(IndexEntry)));
    for (const auto& [time, offset] : entries) {
      fields.number(time);
      fields.number(offset);
    }
    fields.end_record(index);
  }
  current_.message_index_length = record_.size() - current_.length;
  chunks_.push_back(std::exchange(current_, {}));
  entries_.clear();
  chunk_.clear();
  if (auto written = put(record_); !written) return written;
  if (options_.flush_chunks && std::fflush(file_.get()) != 0) {
    return fail(std::string("cannot be written: ") + std::strerror(errno), path_.string());
  }
  return {};
}

Result<void> McapWriter::write_metadata(const std::string& name,
                                        const std::map<std::string, std::string>& pairs) {
  record_.clear();
  FieldWriter fields(record_);
  const size_t record = fields.begin_record(Opcode::kMetadata);
  fields.text(name);
  fields.pairs(pairs);
  fields.end_record(record);
  metadata_.push_back({position_, record_.size(), name});
  return put(record_);
}

void McapWriter::add_statistics(std::vector<uint8_t>& bytes) const {
  FieldWriter fields(bytes);
  const size_t record = fields.begin_record(Opcode::kStatistics);
  fields.number(messages_);
  fields.number(static_cast<uint16_t>(schemas_.size()));
  fields.number(static_cast<uint32_t>(channels_.size()));
  fields.number(uint32_t{0});  // attachments
  fields.number(static_cast<uint32_t>(metadata_.size()));
  fields.number(static_cast<uint32_t>(chunks_.size()));
  fields.number(first_);
  fields.number(last_);
  fields.number(static_cast<uint32_t>(channels_.size() * 10));
  for (size_t id = 0; id < channels_.size(); ++id) {
    fields.number(static_cast<uint16_t>(id));
    fields.number(channels_[id].messages);
  }
  fields.end_record(record);
}

void McapWriter::add_chunk_indexes(std::vector<uint8_t>& bytes) const {
  FieldWriter fields(bytes);
  for (const ChunkIndex& chunk : chunks_) {
    const size_t record = fields.begin_record(Opcode::kChunkIndex);
    fields.number(chunk.first);
    fields.number(chunk.last);
    fields.number(chunk.start);
    fields.number(chunk.length);
    fields.number(static_cast<uint32_t>(chunk.message_indexes.size() * 10));
    for (const auto& [channel, offset] : chunk.message_indexes) {
      fields.number(channel);
      fields.number(offset);
    }
    fields.number(chunk.message_index_length);
    fields.text(name_of(options_.compression));
    fields.number(chunk.compressed);
    fields.number(chunk.uncompressed);
    fields.end_record(record);
  }
}

Result<void> McapWriter::write_summary() {
  std::vector<uint8_t> summary;
  FieldWriter fields(summary);
  struct Group {
    Opcode opcode;
    uint64_t start, length;
  };
  std::vector<Group> groups;
  const auto add_group = [&](Opcode opcode, auto add) {
    const size_t begin = summary.size();
    add();
    if (summary.size() > begin)
      groups.push_back({opcode, position_ + begin, summary.size() - begin});
  };
  add_group(Opcode::kSchema, [&] {
    for (size_t k = 0; k < schemas_.size(); ++k)
      add_schema_record(static_cast<uint16_t>(k + 1), schemas_[k], summary);
  });
  add_group(Opcode::kChannel, [&] {
    for (size_t id = 0; id < channels_.size(); ++id) {
      add_channel_record(static_cast<uint16_t>(id), channels_[id].schema, channels_[id].channel,
                         summary);
    }
  });
  add_group(Opcode::kStatistics, [&] { add_statistics(summary); });
  add_group(Opcode::kChunkIndex, [&] { add_chunk_indexes(summary); });
  add_group(Opcode::kMetadataIndex, [&] {
    for (const MetadataIndex& metadata : metadata_) {
      const size_t record = fields.begin_record(Opcode::kMetadataIndex);
      fields.number(metadata.offset);
      fields.number(metadata.length);
      fields.text(metadata.name);
      fields.end_record(record);
    }
  });
  const uint64_t offsets = position_ + summary.size();
  for (const Group& group : groups) {
    const size_t record = fields.begin_record(Opcode::kSummaryOffset);
    fields.number(group.opcode);
    fields.number(group.start);
    fields.number(group.length);
    fields.end_record(record);
  }
  // The footer's CRC covers the footer up to itself, with its length.
  const uint64_t start = position_;
  const size_t footer = fields.begin_record(Opcode::kFooter);
  fields.number(start);
  fields.number(offsets);
  fields.number(uint32_t{0});
  fields.end_record(footer);
  const uint32_t crc = crc_after(0, std::span(summary).first(summary.size() - sizeof crc));
  std::memcpy(summary.data() + summary.size() - sizeof crc, &crc, sizeof crc);
  fields.raw(kMagic);
  return put(summary);
}

Result<void> McapWriter::close() {
  if (auto ended = end_chunk(); !ended) return ended;
  record_.clear();
  FieldWriter fields(record_);
  const size_t record = fields.begin_record(Opcode::kDataEnd);
  fields.number(data_crc_);
  fields.end_record(record);
  if (auto written = put(record_); !written) return written;
  if (auto written = write_summary(); !written) return written;
  if (std::fclose(file_.release()) != 0) {
    return fail(std::string("cannot be written: ") + std::strerror(errno), path_.string());
  }
  return {};
}

}  // namespace infuse::mcap
