#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/host/file_descriptor.hpp"
#include "drivers/host/time_base.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::vehicle {

/// A serial device that sends lines of text, such as a GNSS receiver.
struct SerialOptions {
  std::string device = "/dev/ttyUSB0";
  /// Bits per second: 4800, 9600, 19200, 38400, 57600, 115200, 230400, 460800.
  uint32_t baud = 9600;

  /// Returns what is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

/// Splits bytes into lines of bounded length. Pure.
class LineSplitter {
 public:
  static constexpr size_t kMaxLineLength = 127;  ///< an NMEA sentence has at most 82 characters

  /// Adds bytes that arrived at `stamp` and calls `on(Stamp, std::string_view)` for each completed
  /// line, stamped with the arrival of its first byte. Line ends and blank lines are omitted; a
  /// line that is too long is dropped and counted.
  template <class OnLine>
  void push(std::string_view bytes, Stamp stamp, OnLine on) {
    for (const char byte : bytes) {
      if (byte == '\n' || byte == '\r') {
        if (too_long_) ++dropped_;
        if (size_ > 0 && !too_long_) on(line_stamp_, std::string_view(line_.data(), size_));
        size_ = 0;
        too_long_ = false;
      } else if (size_ == kMaxLineLength) {
        too_long_ = true;
      } else {
        if (size_ == 0) line_stamp_ = stamp;
        line_[size_++] = byte;
      }
    }
  }

  /// Number of lines that were too long.
  uint64_t dropped() const { return dropped_; }

 private:
  std::array<char, kMaxLineLength> line_{};
  size_t size_ = 0;
  bool too_long_ = false;
  Stamp line_stamp_;
  uint64_t dropped_ = 0;
};

/// Reads lines from a serial device.
class SerialLineSource {
 public:
  /// Opens the device. Errors: no such device (yet), no permission, not a serial device.
  static Result<SerialLineSource> open(const SerialOptions& options, const host::TimeBase& base);

  /// Readable when bytes are pending.
  int descriptor() const { return device_.get(); }

  /// Reads pending bytes and calls `on(Stamp, std::string_view)` for each completed line. Returns
  /// the number of bytes. An error means that the device is gone: open another source later.
  template <class OnLine>
  Result<size_t> read(OnLine on) {
    std::array<char, 512> bytes;
    const ssize_t count = ::read(device_.get(), bytes.data(), bytes.size());
    if (count <= 0) return handle_read_error(count);
    splitter_.push({bytes.data(), static_cast<size_t>(count)}, base_.now(), on);
    return static_cast<size_t>(count);
  }

  const LineSplitter& splitter() const { return splitter_; }

 private:
  SerialLineSource(const SerialOptions& options, const host::TimeBase& base)
      : options_(options), base_(base) {}
  Result<size_t> handle_read_error(ssize_t count) const;

  SerialOptions options_;
  host::TimeBase base_;
  host::FileDescriptor device_;
  LineSplitter splitter_;
};

}  // namespace infuse::vehicle
