#include "drivers/rosbag/bag_reader.hpp"

#include <bzlib.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>

#include "drivers/mcap/compression.hpp"

namespace infuse::rosbag {
namespace {

static_assert(std::endian::native == std::endian::little, "bags are little-endian");

constexpr std::string_view kBagMagic = "#ROSBAG V2.0\n";
constexpr size_t kMaxConnectionBytes = size_t{64} << 20;

enum BagOpcode : uint8_t { kMessageData = 2, kBagHeader = 3, kChunk = 5, kConnection = 7 };

/// The bytes after their length; nothing if they are cut.
std::optional<std::span<const uint8_t>> split_block(std::span<const uint8_t>& rest) {
  uint32_t length = 0;
  if (rest.size() < sizeof length) return std::nullopt;
  std::memcpy(&length, rest.data(), sizeof length);
  if (length > rest.size() - sizeof length) return std::nullopt;
  const auto block = rest.subspan(sizeof length, length);
  rest = rest.subspan(sizeof length + length);
  return block;
}

/// Value of the field of that name, of "name=value" after their lengths; empty if there is none.
std::string_view find_value(std::span<const uint8_t> header, std::string_view name) {
  while (const auto field = split_block(header)) {
    const std::string_view text(reinterpret_cast<const char*>(field->data()), field->size());
    const size_t equals = text.find('=');
    if (equals != std::string_view::npos && text.substr(0, equals) == name)
      return text.substr(equals + 1);
  }
  return {};
}

/// Integer of the field of that name; nothing if there is none of this size.
template <class Number>
std::optional<Number> find_number(std::span<const uint8_t> header, std::string_view name) {
  const std::string_view value = find_value(header, name);
  Number number{};
  if (value.size() != sizeof number) return std::nullopt;
  std::memcpy(&number, value.data(), sizeof number);
  return number;
}

/// As `mcap::decompress_chunk`, for bzip2.
Result<void> decompress_bz2(std::span<const uint8_t> bytes, size_t size,
                            std::vector<uint8_t>& out) {
  if (size > mcap::kMaxChunkBytes) return fail("is larger than 256 MiB");
  constexpr size_t kStep = 1 << 20;
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return fail("cannot be decompressed");
  stream.next_in = const_cast<char*>(reinterpret_cast<const char*>(bytes.data()));  // only read
  stream.avail_in = static_cast<unsigned>(bytes.size());
  out.clear();
  size_t done = 0;
  int state = BZ_OK;
  while (state == BZ_OK) {
    if (done == out.size()) out.resize(std::min(size, 2 * done + kStep));
    const size_t room = out.size() - done;
    stream.next_out = reinterpret_cast<char*>(out.data() + done);
    stream.avail_out = static_cast<unsigned>(room);
    state = BZ2_bzDecompress(&stream);
    done += room - stream.avail_out;
    // Neither the end nor more room or input: the content is longer than stated, or cut.
    if (state == BZ_OK && (stream.avail_in == 0 || done == size) && stream.avail_out == room) break;
  }
  BZ2_bzDecompressEnd(&stream);
  if (state != BZ_STREAM_END || done != size) return fail("cannot be decompressed");
  return {};
}

}  // namespace

bool BagReader::is_bag(std::span<const uint8_t> bytes) {
  return bytes.size() >= kBagMagic.size() &&
         std::memcmp(bytes.data(), kBagMagic.data(), kBagMagic.size()) == 0;
}

Result<BagReader> BagReader::open(std::span<const uint8_t> bytes, const std::string& name) {
  if (!is_bag(bytes)) return fail("is not a bag of ROS 1", name, "expected format 2.0");
  BagReader reader(bytes, name);
  reader.rest_ = bytes.subspan(kBagMagic.size());
  auto rest = reader.rest_;
  const auto header = split_block(rest);
  if (header && find_number<uint8_t>(*header, "op") == kBagHeader &&
      !find_value(*header, "encryptor").empty()) {
    return fail("is encrypted", name, "decrypt it with rosbag");
  }
  return reader;
}

bool BagReader::read_chunk(std::span<const uint8_t> header, std::span<const uint8_t> data) {
  const auto size = find_number<uint32_t>(header, "size");
  const std::string_view compression = find_value(header, "compression");
  if (!size) return false;
  const auto read =
      compression == "none"  ? mcap::decompress_chunk(mcap::Compression::kNone, data, *size, chunk_)
      : compression == "lz4" ? mcap::decompress_chunk(mcap::Compression::kLz4, data, *size, chunk_)
      : compression == "bz2" ? decompress_bz2(data, *size, chunk_)
                             : fail("is in an unknown compression");
  if (!read) return false;
  chunk_rest_ = chunk_;
  return true;
}

void BagReader::read_connection(std::span<const uint8_t> header, std::span<const uint8_t> data) {
  const auto id = find_number<uint32_t>(header, "conn");
  const std::string_view topic = find_value(header, "topic");
  const std::string_view type = find_value(data, "type");
  if (!id || topic.empty() ||
      topic.size() + type.size() > kMaxConnectionBytes - connection_bytes_) {
    ++counters_.damaged_records;
  } else if (connections_.try_emplace(*id, Connection{std::string(topic), std::string(type)})
                 .second) {
    connection_bytes_ += topic.size() + type.size() + sizeof(Connection);
    connection_bytes_ = std::min(connection_bytes_, kMaxConnectionBytes);
  }
}

bool BagReader::read_message(std::span<const uint8_t> header, std::span<const uint8_t> data,
                             BagMessage& message) {
  const auto id = find_number<uint32_t>(header, "conn");
  const auto time = find_number<uint64_t>(header, "time");  // seconds, then nanoseconds
  if (!id || !time) {
    ++counters_.damaged_records;
    return false;
  }
  const auto connection = connections_.find(*id);
  if (connection == connections_.end()) {
    ++counters_.without_connection;
    return false;
  }
  const auto seconds = static_cast<int64_t>(*time & 0xFFFFFFFF);
  const auto nanoseconds = static_cast<int64_t>(*time >> 32);
  message = {&connection->second, Stamp::from_ns(seconds * 1'000'000'000 + nanoseconds), data};
  ++counters_.messages;
  return true;
}

bool BagReader::next(BagMessage& message) {
  while (true) {
    const bool in_chunk = !chunk_rest_.empty();
    auto& rest = in_chunk ? chunk_rest_ : rest_;
    if (rest.empty()) return false;
    const size_t position = size_ - rest_.size();
    const auto header = split_block(rest);
    const auto data = header ? split_block(rest) : std::nullopt;
    if (!data) {
      rest = {};
      if (in_chunk) {
        ++counters_.damaged_records;
        continue;
      }
      notes_.push_back({"ends within a record, at byte " + std::to_string(position), name_,
                        "the messages before it are read"});
      return false;
    }
    switch (find_number<uint8_t>(*header, "op").value_or(0)) {
      case kMessageData:
        if (read_message(*header, *data, message)) return true;
        break;
      case kConnection:
        read_connection(*header, *data);
        break;
      case kChunk:
        if (in_chunk || !read_chunk(*header, *data)) ++counters_.damaged_chunks;
        break;
      default:  // indexes
        break;
    }
  }
}

void BagReader::append_notes(std::vector<Error>& notes) const {
  notes.insert(notes.end(), notes_.begin(), notes_.end());
  const auto count = [&](uint64_t number, const char* what) {
    if (number > 0) notes.push_back({std::to_string(number) + " " + what, name_, ""});
  };
  count(counters_.damaged_chunks, "damaged chunks are skipped");
  count(counters_.damaged_records, "damaged records are skipped");
  count(counters_.without_connection, "messages of unknown connections are skipped");
}

}  // namespace infuse::rosbag
