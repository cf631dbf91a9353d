#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace infuse {

/// A pcap file as its bytes, for rewriting: fields of this host's byte order, Ethernet, IPv4, UDP.
struct RawCapture {
  struct Record {
    uint32_t seconds = 0, fraction = 0, wire_length = 0;
    std::vector<uint8_t> frame;

    bool is_data() const { return frame.size() == kPayload + 1206; }
    bool is_position() const { return frame.size() == kPayload + 512; }
    uint8_t* payload() { return frame.data() + kPayload; }
    /// A block of a data packet.
    uint8_t* block(size_t i) { return payload() + 100 * i; }
  };
  static constexpr size_t kPayload = 14 + 20 + 8;

  std::string header;  ///< 24 bytes
  std::vector<Record> records;

  static RawCapture read(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(file), {});
    RawCapture capture{bytes.substr(0, 24), {}};
    for (size_t at = 24; at + 16 <= bytes.size();) {
      uint32_t fields[4];
      std::memcpy(fields, bytes.data() + at, sizeof fields);
      const auto* begin = reinterpret_cast<const uint8_t*>(bytes.data()) + at + 16;
      capture.records.push_back({fields[0], fields[1], fields[3], {begin, begin + fields[2]}});
      at += 16 + fields[2];
    }
    return capture;
  }

  void write(const std::filesystem::path& path) const {
    std::ofstream file(path, std::ios::binary);
    file << header;
    for (const Record& record : records) {
      const uint32_t fields[4] = {record.seconds, record.fraction,
                                  static_cast<uint32_t>(record.frame.size()), record.wire_length};
      file.write(reinterpret_cast<const char*>(fields), sizeof fields);
      file.write(reinterpret_cast<const char*>(record.frame.data()),
                 static_cast<std::streamsize>(record.frame.size()));
    }
  }

  /// Records of data packets, for rewriting.
  std::vector<Record*> data() {
    std::vector<Record*> found;
    for (Record& record : records) {
      if (record.is_data()) found.push_back(&record);
    }
    return found;
  }
};

}  // namespace infuse
