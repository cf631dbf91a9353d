#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

/// The messages of infuse.lcm. Each has the members of its definition in their order, and
/// `members(archive)`, which hands them to a `TypeHash` or an `LcmEncoder`.
namespace infuse::lcm {

/// Pose of the vehicle in the frame `odom` or `map`.
struct PoseMessage {
  int64_t utime = 0;  ///< µs since 1970
  std::string frame;
  std::array<double, 3> position{};     ///< m
  std::array<double, 4> orientation{};  ///< w, x, y, z
  std::array<double, 36> covariance{};  ///< by row: x, y, z, rotation about x, y, z
  double speed = 0;                     ///< m/s
  double yaw_rate = 0;                  ///< rad/s
  void members(auto& archive) const {
    archive.member("utime", utime);
    archive.member("frame", frame);
    archive.member("position", position);
    archive.member("orientation", orientation);
    archive.member("covariance", covariance);
    archive.member("speed", speed);
    archive.member("yaw_rate", yaw_rate);
  }
};

/// A sweep, deskewed if `deskewed` says so.
struct SweepMessage {
  int64_t utime = 0;  ///< µs since 1970
  std::string lidar;
  bool deskewed = false;
  std::vector<float> x, y, z;       ///< m, lidar frame; all vectors have the same length
  std::vector<float> reflectivity;  ///< 0 … 1
  std::vector<int16_t> ring;
  void members(auto& archive) const {
    archive.member("utime", utime);
    archive.member("lidar", lidar);
    archive.member("deskewed", deskewed);
    archive.member("points", static_cast<int32_t>(x.size()));
    archive.member("x", x, "points");
    archive.member("y", y, "points");
    archive.member("z", z, "points");
    archive.member("reflectivity", reflectivity, "points");
    archive.member("ring", ring, "points");
  }
};

/// An alert that was raised or cleared.
struct AlertMessage {
  int64_t utime = 0;  ///< µs since 1970
  std::string id, device, severity, state, what, advice;
  void members(auto& archive) const {
    archive.member("utime", utime);
    archive.member("id", id);
    archive.member("device", device);
    archive.member("severity", severity);
    archive.member("state", state);
    archive.member("what", what);
    archive.member("advice", advice);
  }
};

/// Computes the fingerprint of a type as lcm-gen does: from the names and primitive types of its
/// members, and the sizes of arrays.
class TypeHash {
 public:
  template <class T>
  void member(const char* name, const T& value) {
    add_text(name);
    if constexpr (requires { std::tuple_size<T>::value; }) {
      add_text(type_name(value[0]));
      add_dimension(0, std::to_string(value.size()));
    } else {
      add_text(type_name(value));
      add(0);
    }
  }
  template <class T>
  void member(const char* name, const std::vector<T>&, const char* size) {
    add_text(name);
    add_text(type_name(T{}));
    add_dimension(1, size);
  }
  /// The fingerprint, which begins each message.
  uint64_t value() const { return std::rotl(hash_, 1); }

 private:
  static const char* type_name(int16_t) { return "int16_t"; }
  static const char* type_name(int32_t) { return "int32_t"; }
  static const char* type_name(int64_t) { return "int64_t"; }
  static const char* type_name(float) { return "float"; }
  static const char* type_name(double) { return "double"; }
  static const char* type_name(bool) { return "boolean"; }
  static const char* type_name(const std::string&) { return "string"; }

  void add(uint64_t value) {
    const auto shifted = static_cast<uint64_t>(static_cast<int64_t>(hash_) >> 55);
    hash_ = ((hash_ << 8) ^ shifted) + value;
  }
  void add_text(std::string_view text) {
    add(text.size());
    for (const char c : text) add(static_cast<uint64_t>(c));
  }
  void add_dimension(uint64_t kind, std::string_view size) {
    add(1);  // one dimension
    add(kind);
    add_text(size);
  }
  uint64_t hash_ = 0x12345678;
};

/// Appends members, big-endian.
class LcmEncoder {
 public:
  explicit LcmEncoder(std::vector<uint8_t>& bytes) : bytes_(bytes) {}

  template <class T>
  void member(const char*, const T& value) {
    write(value);
  }
  template <class T>
  void member(const char*, const std::vector<T>& values, const char*) {
    for (const T& value : values) write(value);
  }
  template <class T>
  requires std::is_arithmetic_v<T>
  void write(T value) {
    std::array<uint8_t, sizeof(T)> bytes;
    std::memcpy(bytes.data(), &value, sizeof value);
    bytes_.insert(bytes_.end(), bytes.rbegin(), bytes.rend());
  }

 private:
  static_assert(std::endian::native == std::endian::little);
  template <class T, size_t N>
  void write(const std::array<T, N>& values) {
    for (const T& value : values) write(value);
  }
  void write(const std::string& text) {
    write(static_cast<int32_t>(text.size() + 1));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    bytes_.push_back(0);
  }
  std::vector<uint8_t>& bytes_;
};

/// Fingerprint of a message's type.
template <class Message>
uint64_t fingerprint(const Message& message) {
  TypeHash hash;
  message.members(hash);
  return hash.value();
}

/// Fills `bytes` with the message, after its fingerprint.
template <class Message>
void encode(const Message& message, std::vector<uint8_t>& bytes) {
  bytes.clear();
  LcmEncoder encoder(bytes);
  encoder.write(fingerprint(message));
  message.members(encoder);
}

}  // namespace infuse::lcm
