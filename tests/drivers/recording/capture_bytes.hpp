#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace infuse::recording::testing {

using Bytes = std::vector<uint8_t>;

// Builds captures byte by byte according to RFC 768, RFC 791, IEEE 802.1Q, the pcap and pcapng
// drafts and tcpdump.org's list of link types, independently of the code under test.

inline void add_be16(Bytes& bytes, uint32_t value) {
  bytes.push_back(static_cast<uint8_t>(value >> 8));
  bytes.push_back(static_cast<uint8_t>(value));
}
inline void add_be32(Bytes& bytes, uint32_t value) {
  add_be16(bytes, value >> 16);
  add_be16(bytes, value & 0xFFFF);
}
inline void add_le16(Bytes& bytes, uint32_t value) {
  bytes.push_back(static_cast<uint8_t>(value));
  bytes.push_back(static_cast<uint8_t>(value >> 8));
}
inline void add_le32(Bytes& bytes, uint32_t value) {
  add_le16(bytes, value & 0xFFFF);
  add_le16(bytes, value >> 16);
}
inline void add(Bytes& bytes, const Bytes& more) {
  bytes.insert(bytes.end(), more.begin(), more.end());
}

inline constexpr uint32_t kSender = 0xC0A801C9;  // 192.168.1.201
inline constexpr uint32_t kReceiver = 0xC0A80164;

inline Bytes make_payload(size_t length, uint32_t seed = 0) {
  Bytes bytes(length);
  for (size_t i = 0; i < length; ++i) bytes[i] = static_cast<uint8_t>(i * 7 + i / 256 + seed);
  return bytes;
}

inline Bytes udp(const Bytes& payload, uint16_t to = 2368, uint16_t from = 2368) {
  Bytes bytes;
  add_be16(bytes, from);
  add_be16(bytes, to);
  add_be16(bytes, static_cast<uint32_t>(8 + payload.size()));
  add_be16(bytes, 0);
  add(bytes, payload);
  return bytes;
}

struct Ipv4 {
  uint32_t sender = kSender;
  uint8_t protocol = 17;
  uint16_t identification = 0;
  size_t offset = 0;  // bytes
  bool more = false;
  size_t option_words = 0;
};

inline Bytes ipv4(const Bytes& payload, const Ipv4& header = {}) {
  Bytes bytes;
  const size_t length = 20 + 4 * header.option_words;
  bytes.push_back(static_cast<uint8_t>(0x40 | (length / 4)));
  bytes.push_back(0);
  add_be16(bytes, static_cast<uint32_t>(length + payload.size()));
  add_be16(bytes, header.identification);
  add_be16(bytes, static_cast<uint32_t>((header.more ? 0x2000 : 0) | (header.offset / 8)));
  bytes.push_back(64);
  bytes.push_back(header.protocol);
  add_be16(bytes, 0);
  add_be32(bytes, header.sender);
  add_be32(bytes, kReceiver);
  bytes.resize(length, 1);  // no-operation options
  add(bytes, payload);
  return bytes;
}

/// An extension header in front of the payload, or what a fragment header says.
struct Ipv6 {
  uint32_t sender = kSender;  // the last four bytes of the address
  uint8_t protocol = 17;
  uint32_t identification = 0;
  size_t offset = 0;  // bytes
  bool more = false, fragment = false, options = false;
};

inline Bytes ipv6(const Bytes& payload, const Ipv6& header = {}) {
  Bytes inner;
  const uint8_t first = header.fragment ? 44 : header.protocol;
  if (header.options) add(inner, {first, 1, 1, 12, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  if (header.fragment) {
    add(inner, {header.protocol, 0});
    add_be16(inner, static_cast<uint32_t>(header.offset | (header.more ? 1 : 0)));
    add_be32(inner, header.identification);
  }
  add(inner, payload);
  Bytes bytes{0x60, 0, 0, 0};
  add_be16(bytes, static_cast<uint32_t>(inner.size()));
  add(bytes, {header.options ? uint8_t{60} : first, 64});
  for (const uint32_t end : {header.sender, kReceiver}) {
    add_be32(bytes, 0xFE800000);
    add_be32(bytes, 0);
    add_be32(bytes, 0x655B4978);
    add_be32(bytes, end);
  }
  add(bytes, inner);
  return bytes;
}

// `tags`: pairs (EtherType of the tag, tag control information).
inline Bytes ethernet(const Bytes& packet,
                      const std::vector<std::pair<uint16_t, uint16_t>>& tags = {},
                      uint16_t type = 0x0800) {
  Bytes bytes(12, 0xAB);
  for (const auto& [tag, control] : tags) {
    add_be16(bytes, tag);
    add_be16(bytes, control);
  }
  add_be16(bytes, type);
  add(bytes, packet);
  return bytes;
}

inline Bytes linux_cooked_v1(const Bytes& packet, uint16_t type = 0x0800) {
  Bytes bytes;
  add_be16(bytes, 0);
  add_be16(bytes, 1);
  add_be16(bytes, 6);
  bytes.resize(14, 0xCD);
  add_be16(bytes, type);
  add(bytes, packet);
  return bytes;
}

inline Bytes linux_cooked_v2(const Bytes& packet, uint16_t type = 0x0800) {
  Bytes bytes;
  add_be16(bytes, type);
  add_be16(bytes, 0);
  add_be32(bytes, 3);  // interface
  add_be16(bytes, 1);
  bytes.push_back(0);
  bytes.push_back(6);
  bytes.resize(20, 0xEF);
  add(bytes, packet);
  return bytes;
}

// LINKTYPE_ numbers of tcpdump.org.
inline constexpr uint32_t kNull = 0, kEthernet = 1, kRaw = 101, kLoop = 108, kCooked1 = 113,
                          kIpv4Link = 228, kCooked2 = 276;

struct Record {
  uint32_t seconds = 0;
  uint32_t fraction = 0;  // microseconds or nanoseconds
  Bytes frame;
  uint32_t truncated_bytes = 0;  // bytes missing at the end (snapshot length)
};

inline Bytes pcap_header(uint32_t link_type, bool nanoseconds) {
  Bytes bytes;
  add_le32(bytes, nanoseconds ? 0xA1B23C4D : 0xA1B2C3D4);
  add_le16(bytes, 2);
  add_le16(bytes, 4);
  add_le32(bytes, 0);
  add_le32(bytes, 0);
  add_le32(bytes, 65535);
  add_le32(bytes, link_type);
  return bytes;
}

inline Bytes pcap(uint32_t link_type, const std::vector<Record>& records, bool nanoseconds = true) {
  Bytes bytes = pcap_header(link_type, nanoseconds);
  for (const Record& record : records) {
    const auto wire = static_cast<uint32_t>(record.frame.size());
    add_le32(bytes, record.seconds);
    add_le32(bytes, record.fraction);
    add_le32(bytes, wire - record.truncated_bytes);
    add_le32(bytes, wire);
    bytes.insert(bytes.end(), record.frame.begin(), record.frame.end() - record.truncated_bytes);
  }
  return bytes;
}

inline void add_block(Bytes& bytes, uint32_t type, Bytes body) {
  body.resize((body.size() + 3) / 4 * 4, 0);
  const auto length = static_cast<uint32_t>(body.size() + 12);
  add_le32(bytes, type);
  add_le32(bytes, length);
  add(bytes, body);
  add_le32(bytes, length);
}

// One section, one interface of nanosecond resolution (if_tsresol 9), enhanced packet blocks.
inline Bytes pcapng(uint32_t link_type, const std::vector<Record>& records) {
  Bytes bytes, body;
  add_le32(body, 0x1A2B3C4D);
  add_le16(body, 1);
  add_le16(body, 0);
  add_le32(body, 0xFFFFFFFF);
  add_le32(body, 0xFFFFFFFF);
  add_block(bytes, 0x0A0D0D0A, body);

  body.clear();
  add_le16(body, link_type);
  add_le16(body, 0);
  add_le32(body, 65535);
  add_le16(body, 9);  // if_tsresol
  add_le16(body, 1);
  add_le32(body, 9);
  add_le32(body, 0);  // end of options
  add_block(bytes, 1, body);

  for (const Record& record : records) {
    const uint64_t ns = uint64_t{record.seconds} * 1'000'000'000 + record.fraction;
    const auto wire = static_cast<uint32_t>(record.frame.size());
    body.clear();
    add_le32(body, 0);
    add_le32(body, static_cast<uint32_t>(ns >> 32));
    add_le32(body, static_cast<uint32_t>(ns));
    add_le32(body, wire - record.truncated_bytes);
    add_le32(body, wire);
    body.insert(body.end(), record.frame.begin(), record.frame.end() - record.truncated_bytes);
    add_block(bytes, 6, body);
  }
  return bytes;
}

}  // namespace infuse::recording::testing
