#pragma once

#include <cstdint>
#include <string>

namespace infuse::lcm {

/// An integer, big-endian.
template <class Number>
std::string big_endian(Number value) {
  std::string bytes;
  for (size_t k = sizeof value; k-- > 0;)
    bytes += static_cast<char>(static_cast<uint64_t>(value) >> (8 * k) & 0xFF);
  return bytes;
}

/// An event as LCM's description of the log format states it.
inline std::string make_event(uint64_t number, uint64_t time_us, const std::string& channel,
                              const std::string& data) {
  return "\xED\xA1\xDA\x01" + big_endian(number) + big_endian(time_us) +
         big_endian(static_cast<uint32_t>(channel.size())) +
         big_endian(static_cast<uint32_t>(data.size())) + channel + data;
}

/// A message of a type that is a time and a list of bytes: fingerprint, time in µs, length, bytes.
inline std::string make_raw_message(uint64_t time_us, const std::string& bytes) {
  return "\x12\x34\x56\x78\x9A\xBC\xDE\xF0" + big_endian(time_us) +
         big_endian(static_cast<uint32_t>(bytes.size())) + bytes;
}

}  // namespace infuse::lcm
