#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace infuse::ros {

/// How messages become bytes.
enum class Encoding : uint8_t {
  kCdr,   ///< of ROS 2: XCDR version 1, after four bytes that name it
  kRos1,  ///< of ROS 1: little-endian, packed, headers with a sequence number
};

namespace detail {

template <class T>
concept Number = std::is_arithmetic_v<T>;

static_assert(std::endian::native == std::endian::little, "numbers are read in memory order");

/// Reverses the bytes of a number.
template <Number T>
T swap_bytes(T value) {
  std::array<uint8_t, sizeof(T)> bytes;
  std::memcpy(bytes.data(), &value, sizeof(T));
  std::ranges::reverse(bytes);
  std::memcpy(&value, bytes.data(), sizeof(T));
  return value;
}

}  // namespace detail

/// Reads the fields of a message in order. A field behind the end of the bytes leaves `ok` false.
/// Memory is bounded by that of the bytes.
class Decoder {
 public:
  static constexpr bool kReads = true;

  /// `bytes` as they are in the file. `ok` is false at once if they are CDR of an unknown kind.
  Decoder(std::span<const uint8_t> bytes, Encoding encoding)
      : body_(bytes), packed_(encoding == Encoding::kRos1) {
    if (packed_) return;
    // Representation: 0 big-endian, 1 little-endian; the other kinds are not of plain messages.
    ok_ = bytes.size() >= 4 && bytes[0] == 0 && bytes[1] <= 1;
    if (!ok_) return;
    swap_ = bytes[1] == 0;
    body_ = bytes.subspan(4);
  }

  bool ok() const { return ok_; }
  /// True if headers have a sequence number.
  bool has_sequences() const { return packed_; }

  template <class... Fields>
  void operator()(Fields&... fields) {
    (read(fields), ...);
  }

 private:
  template <detail::Number T>
  void read(T& value) {
    align(sizeof(T));
    const auto bytes = take(sizeof(T));
    if (!ok_) return;
    if constexpr (std::same_as<T, bool>) {
      value = bytes[0] != 0;
    } else {
      std::memcpy(&value, bytes.data(), sizeof(T));
      if (swap_) value = detail::swap_bytes(value);
    }
  }
  void read(std::string& text) {
    const auto bytes = take(length());
    text.assign(bytes.begin(), bytes.end());
    if (!packed_ && !text.empty() && text.back() == '\0') text.pop_back();
  }
  void read(std::span<const uint8_t>& bytes) { bytes = take(length()); }
  template <class T, size_t N>
  void read(std::array<T, N>& values) {
    if constexpr (std::same_as<T, uint8_t>) {
      const auto bytes = take(N);
      std::ranges::copy(bytes, values.begin());
    } else {
      for (T& value : values) read(value);
    }
  }
  template <class T>
  void read(std::vector<T>& values) {
    values.clear();
    for (uint32_t left = length(); left > 0 && ok_; --left) {
      if (at_ >= body_.size()) {
        ok_ = false;  // also for a count of elements that have no bytes
        break;
      }
      read(values.emplace_back());
    }
  }
  template <class T>
  void read(T& message) {
    message.fields(*this);
  }

  uint32_t length() {
    uint32_t count = 0;
    read(count);
    return count;
  }
  void align(size_t size) {
    if (!packed_) at_ = (at_ + size - 1) / size * size;
  }
  std::span<const uint8_t> take(size_t count) {
    ok_ = ok_ && at_ <= body_.size() && count <= body_.size() - at_;
    if (!ok_) return {};
    at_ += count;
    return body_.subspan(at_ - count, count);
  }

  std::span<const uint8_t> body_;
  size_t at_ = 0;
  bool packed_;
  bool swap_ = false;
  bool ok_ = true;
};

/// Appends the fields of a message to a buffer, little-endian or as asked for.
class Encoder {
 public:
  static constexpr bool kReads = false;

  /// Clears `bytes` and keeps its memory. `big_endian`: of CDR alone.
  Encoder(std::vector<uint8_t>& bytes, Encoding encoding, bool big_endian = false)
      : bytes_(bytes), packed_(encoding == Encoding::kRos1), swap_(big_endian && !packed_) {
    bytes_.clear();
    if (!packed_) bytes_.assign({0, static_cast<uint8_t>(swap_ ? 0 : 1), 0, 0});
  }

  bool has_sequences() const { return packed_; }

  template <class... Fields>
  void operator()(const Fields&... fields) {
    (write(fields), ...);
  }

 private:
  template <detail::Number T>
  void write(const T& number) {
    const T value = swap_ ? detail::swap_bytes(number) : number;
    // Alignment counts from after the first four bytes, which are a multiple of four only.
    while (!packed_ && (bytes_.size() - 4) % sizeof(T) != 0) bytes_.push_back(0);
    const size_t at = bytes_.size();
    bytes_.resize(at + sizeof(T));
    std::memcpy(bytes_.data() + at, &value, sizeof(T));
  }
  void write(const std::string& text) {
    write(static_cast<uint32_t>(text.size() + (packed_ ? 0 : 1)));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    if (!packed_) bytes_.push_back(0);
  }
  void write(const std::span<const uint8_t>& bytes) {
    write(static_cast<uint32_t>(bytes.size()));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  template <class T, size_t N>
  void write(const std::array<T, N>& values) {
    if constexpr (std::same_as<T, uint8_t>) {
      bytes_.insert(bytes_.end(), values.begin(), values.end());
    } else {
      for (const T& value : values) write(value);
    }
  }
  template <class T>
  void write(const std::vector<T>& values) {
    write(static_cast<uint32_t>(values.size()));
    for (const T& value : values) write(value);
  }
  template <class T>
  void write(const T& message) {
    const_cast<T&>(message).fields(*this);  // which only reads them
  }

  std::vector<uint8_t>& bytes_;
  bool packed_;
  bool swap_;
};

/// Returns the message in `bytes`, or nothing if they end before it does. Spans of the message
/// point into `bytes`.
template <class T>
std::optional<T> decode(std::span<const uint8_t> bytes, Encoding encoding) {
  T message;
  Decoder decoder(bytes, encoding);
  decoder(message);
  if (!decoder.ok()) return std::nullopt;
  return message;
}

/// Fills `bytes` with the message.
template <class T>
void encode(const T& message, Encoding encoding, std::vector<uint8_t>& bytes) {
  Encoder encoder(bytes, encoding);
  encoder(message);
}

}  // namespace infuse::ros
