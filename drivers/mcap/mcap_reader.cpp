#include "drivers/mcap/mcap_reader.hpp"

#include <zlib.h>

#include <algorithm>
#include <limits>

#include "drivers/mcap/compression.hpp"
#include "drivers/mcap/record_bytes.hpp"

namespace infuse::mcap {
namespace {

constexpr size_t kMaxTextBytes = size_t{64} << 20;  // of schemas, channels and metadata
constexpr size_t kMaxNotes = 20;
constexpr size_t kFooterBytes = 8 + 8 + 4;

uint32_t crc_of(std::span<const uint8_t> bytes) {
  return static_cast<uint32_t>(crc32_z(0, bytes.data(), bytes.size()));
}

Stamp to_stamp(uint64_t ns) {
  constexpr auto kLatest = static_cast<uint64_t>(std::numeric_limits<int64_t>::max());
  return Stamp::from_ns(static_cast<int64_t>(std::min(ns, kLatest)));
}

bool has_magic(std::span<const uint8_t> bytes) { return std::ranges::equal(bytes, kMagic); }

}  // namespace

Result<McapReader> McapReader::open(std::span<const uint8_t> bytes, const std::string& name) {
  if (bytes.size() < kMagic.size() || !has_magic(bytes.first(kMagic.size()))) {
    return fail("is not an MCAP file", name, "it does not begin with the magic of version 0");
  }
  McapReader reader(bytes, name);
  reader.read_summary();
  reader.rest_ = bytes.subspan(kMagic.size());
  return reader;
}

std::optional<McapReader::Record> McapReader::split_record(std::span<const uint8_t>& rest) {
  FieldReader fields(rest);
  Record record;
  record.opcode = fields.number<uint8_t>();
  record.content = fields.take(fields.number<uint64_t>());
  if (!fields.ok()) return std::nullopt;
  rest = fields.rest();
  return record;
}

void McapReader::note(std::string what, std::string hint) {
  if (notes_.size() < kMaxNotes) notes_.push_back({std::move(what), name_, std::move(hint)});
}

// The summary repeats schemas and channels, so that messages are read whose chunk with the
// description of their channel is damaged.
void McapReader::read_summary() {
  constexpr size_t kEnd = kRecordHeader + kFooterBytes + kMagic.size();
  if (bytes_.size() < kMagic.size() + kEnd || !has_magic(bytes_.last(kMagic.size()))) return;
  auto end = bytes_.last(kEnd);
  const auto footer = split_record(end);
  if (!footer || footer->opcode != static_cast<uint8_t>(Opcode::kFooter)) return;
  FieldReader fields(footer->content);
  const auto begin = fields.number<uint64_t>();
  fields.number<uint64_t>();
  const auto crc = fields.number<uint32_t>();
  complete_ = fields.ok();
  if (begin == 0) return;
  if (begin > bytes_.size() - kEnd) return note("has a summary outside the file");
  auto summary = bytes_.subspan(static_cast<size_t>(begin));
  const size_t checked = summary.size() - kMagic.size() - sizeof crc;
  if (crc != 0 && crc_of(summary.first(checked)) != crc) {
    return note("has a damaged summary", "the messages are read without it");
  }
  summary = summary.first(summary.size() - kEnd);
  while (const auto record = split_record(summary)) {
    if (record->opcode == static_cast<uint8_t>(Opcode::kSchema)) read_schema(record->content);
    if (record->opcode == static_cast<uint8_t>(Opcode::kChannel)) read_channel(record->content);
  }
}

bool McapReader::keep_text(size_t bytes) {
  if (bytes > kMaxTextBytes - text_bytes_) {
    note("has more than 64 MiB of schemas", "the rest of them is skipped");
    return false;
  }
  text_bytes_ += bytes;
  return true;
}

void McapReader::read_schema(std::span<const uint8_t> content) {
  FieldReader fields(content);
  const auto id = fields.number<uint16_t>();
  const auto name = fields.text();
  const auto encoding = fields.text();
  const auto text = fields.text();
  if (!fields.ok()) {
    ++counters_.damaged_records;
  } else if (!schemas_.contains(id) && keep_text(content.size())) {
    schemas_[id] = {std::string(name), std::string(encoding), std::string(text)};
  }
}

void McapReader::read_channel(std::span<const uint8_t> content) {
  FieldReader fields(content);
  const auto id = fields.number<uint16_t>();
  const auto schema = fields.number<uint16_t>();
  const auto topic = fields.text();
  const auto encoding = fields.text();
  if (!fields.ok()) {
    ++counters_.damaged_records;
    return;
  }
  if (channels_.contains(id)) return;
  const auto found = schemas_.find(schema);
  const size_t schema_bytes = found == schemas_.end() ? 0 : found->second.text.size();
  if (!keep_text(content.size() + schema_bytes)) return;
  Channel channel{std::string(topic), std::string(encoding), {}, fields.pairs()};
  if (!fields.ok()) {
    ++counters_.damaged_records;
    return;
  }
  if (found != schemas_.end()) channel.schema = found->second;
  channels_.emplace(id, std::move(channel));
}

void McapReader::read_metadata(std::span<const uint8_t> content) {
  if (!keep_text(content.size())) return;
  FieldReader fields(content);
  const std::string name(fields.text());
  auto pairs = fields.pairs();
  if (fields.ok()) {
    metadata_[name].merge(pairs);
  } else {
    ++counters_.damaged_records;
  }
}

bool McapReader::read_chunk(std::span<const uint8_t> content) {
  FieldReader fields(content);
  fields.number<uint64_t>();  // time of the first message
  fields.number<uint64_t>();  // of the last
  const auto size = fields.number<uint64_t>();
  const auto crc = fields.number<uint32_t>();
  const auto compression = find_compression(fields.text());
  const auto bytes = fields.take(fields.number<uint64_t>());
  if (!fields.ok()) {
    note("has a chunk that is shorter than its fields");
    return false;
  }
  if (!compression) {
    note("has a chunk in an unknown compression", "known: none, lz4, zstd");
    return false;
  }
  if (const auto read = decompress_chunk(*compression, bytes, size, chunk_); !read) {
    note("has a chunk that " + read.error().what);
    return false;
  }
  if (crc != 0 && crc_of(chunk_) != crc) {
    note("has a chunk whose CRC is wrong");
    return false;
  }
  chunk_rest_ = chunk_;
  return true;
}

bool McapReader::read_message(std::span<const uint8_t> content, Message& message) {
  FieldReader fields(content);
  message.channel_id = fields.number<uint16_t>();
  message.sequence = fields.number<uint32_t>();
  message.log_time = to_stamp(fields.number<uint64_t>());
  message.publish_time = to_stamp(fields.number<uint64_t>());
  message.data = fields.rest();
  if (!fields.ok()) {
    ++counters_.damaged_records;
    return false;
  }
  const auto channel = channels_.find(message.channel_id);
  if (channel == channels_.end()) {
    ++counters_.without_channel;
    return false;
  }
  message.channel = &channel->second;
  ++counters_.messages;
  return true;
}

void McapReader::end_data(std::span<const uint8_t> content, size_t data_bytes) {
  FieldReader fields(content);
  const auto crc = fields.number<uint32_t>();
  if (crc != 0 && crc_of(bytes_.first(data_bytes)) != crc) {
    note("has a wrong CRC of its data", "some of the messages may be damaged");
  }
  rest_ = {};
}

bool McapReader::next(Message& message) {
  while (true) {
    const bool in_chunk = !chunk_rest_.empty();
    auto& rest = in_chunk ? chunk_rest_ : rest_;
    if (rest.empty()) return false;
    const size_t position = bytes_.size() - rest_.size();
    const auto record = split_record(rest);
    if (!record) {
      rest = {};
      if (in_chunk) {
        ++counters_.damaged_records;
        continue;
      }
      note("ends within a record, at byte " + std::to_string(position),
           "the messages before it are read");
      return false;
    }
    if (read_record(*record, in_chunk, position, message)) return true;
  }
}

bool McapReader::read_record(const Record& record, bool in_chunk, size_t position,
                             Message& message) {
  const std::span<const uint8_t> content = record.content;
  switch (static_cast<Opcode>(record.opcode)) {
    case Opcode::kSchema:
      read_schema(content);
      break;
    case Opcode::kChannel:
      read_channel(content);
      break;
    case Opcode::kMessage:
      return read_message(content, message);
    case Opcode::kChunk:
      if (in_chunk) {
        ++counters_.damaged_records;
        break;
      }
      ++counters_.chunks;
      if (!read_chunk(content)) ++counters_.damaged_chunks;
      break;
    case Opcode::kMetadata:
      read_metadata(content);
      break;
    case Opcode::kAttachment:
      ++counters_.attachments;
      break;
    case Opcode::kDataEnd:
    case Opcode::kFooter:
      if (in_chunk) {
        ++counters_.damaged_records;
      } else {
        end_data(content, position);
      }
      break;
    case Opcode::kHeader:
    case Opcode::kMessageIndex:
    case Opcode::kChunkIndex:
    case Opcode::kAttachmentIndex:
    case Opcode::kStatistics:
    case Opcode::kMetadataIndex:
    case Opcode::kSummaryOffset:
      break;
    default:
      ++counters_.unknown_records;
  }
  return false;
}

void McapReader::append_notes(std::vector<Error>& notes) const {
  notes.insert(notes.end(), notes_.begin(), notes_.end());
  const auto count = [&](uint64_t number, const char* what) {
    if (number > 0) notes.push_back({std::to_string(number) + " " + what, name_, ""});
  };
  count(counters_.damaged_chunks, "damaged chunks are skipped");
  count(counters_.damaged_records, "damaged records are skipped");
  count(counters_.without_channel, "messages of unknown channels are skipped");
  count(counters_.unknown_records, "records of unknown kinds are skipped");
  count(counters_.attachments, "attachments are skipped");
}

}  // namespace infuse::mcap
