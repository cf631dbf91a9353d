#pragma once

#include <bzlib.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "drivers/mcap/compression.hpp"

namespace infuse::rosbag {

/// Makes bags as rosbag's description of format 2.0 states it.
class BagBytes {
 public:
  explicit BagBytes(const std::string& encryptor = "") {
    bytes_ = "#ROSBAG V2.0\n";
    bytes_ += record({{"op", "\x03"},
                      {"index_pos", number(uint64_t{0})},
                      {"conn_count", number(uint32_t{2})},
                      {"chunk_count", number(uint32_t{1})},
                      {"encryptor", encryptor}},
                     std::string(100, ' '));
  }

  static std::string connection(uint32_t id, const std::string& topic, const std::string& type) {
    return record({{"op", "\x07"}, {"conn", number(id)}, {"topic", topic}},
                  fields({{"topic", topic}, {"type", type}, {"md5sum", "*"}}));
  }
  static std::string message(uint32_t id, uint32_t seconds, uint32_t nanoseconds,
                             const std::string& data) {
    return record(
        {{"op", "\x02"}, {"conn", number(id)}, {"time", number(seconds) + number(nanoseconds)}},
        data);
  }
  /// A chunk and the record of its index.
  void add_chunk(const std::string& compression, const std::string& content) {
    std::string data = content;
    if (compression == "lz4") {
      std::vector<uint8_t> out;
      static_cast<void>(mcap::compress_chunk(
          mcap::Compression::kLz4,
          {reinterpret_cast<const uint8_t*>(content.data()), content.size()}, out));
      data.assign(out.begin(), out.end());
    } else if (compression == "bz2") {
      auto length = static_cast<unsigned>(content.size() + content.size() / 100 + 600);
      data.resize(length);
      BZ2_bzBuffToBuffCompress(data.data(), &length, const_cast<char*>(content.data()),
                               static_cast<unsigned>(content.size()), 9, 0, 30);
      data.resize(length);
    }
    bytes_ += record({{"op", "\x05"},
                      {"compression", compression},
                      {"size", number(static_cast<uint32_t>(content.size()))}},
                     data);
    bytes_ += record({{"op", "\x04"}, {"ver", number(uint32_t{1})}, {"conn", number(uint32_t{0})}},
                     std::string(24, 'i'));
  }
  const std::string& bytes() const { return bytes_; }

 private:
  using Fields = std::vector<std::pair<std::string, std::string>>;

  template <class Number>
  static std::string number(Number value) {
    std::string bytes(sizeof value, '\0');
    std::memcpy(bytes.data(), &value, sizeof value);
    return bytes;
  }
  static std::string block(const std::string& bytes) {
    return number(static_cast<uint32_t>(bytes.size())) + bytes;
  }
  static std::string fields(const Fields& pairs) {
    std::string bytes;
    for (const auto& [name, value] : pairs) {
      std::string pair = name;
      pair += '=';
      pair += value;
      bytes += block(pair);
    }
    return bytes;
  }
  static std::string record(const Fields& header, const std::string& data) {
    return block(fields(header)) + block(data);
  }

  std::string bytes_;
};

}  // namespace infuse::rosbag
