#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "drivers/velodyne/calibration.hpp"

namespace infuse::velodyne {

/// Collects an HDL-64E's calibration from the last two bytes of successive packets. These are
/// (type, value) pairs; pairs of clock, GPS, temperature and firmware are skipped, the rest is an
/// 1820-byte cycle: "UNIT#", 2 bytes, 64 records of 21 bytes every 28, 26 bytes; on an S3 the last
/// two are a CRC-16. A cycle takes 4160 packets, 1.2 to 1.5 seconds.
class CalibrationStream {
 public:
  /// `model` must be an HDL-64E.
  explicit CalibrationStream(Model model) : model_(model) {}

  /// Adds a packet's bytes 1204 and 1205. Returns the calibration when a cycle is complete and
  /// valid: it begins and ends with "UNIT#", its records are numbered 0 … 63, its numbers are
  /// possible and, on an S3, its checksum matches.
  std::optional<Calibration> add(uint8_t type, uint8_t value);

  /// Discards the collected bytes, for lost packets.
  void restart();

 private:
  static constexpr size_t kCycleBytes = 1820;
  static constexpr size_t kMarkerBytes = 5;  ///< length of "UNIT#"

  /// The last bytes of the cycle and of the marker that follows it.
  class Window {
   public:
    void push(uint8_t byte);
    void clear() { count_ = 0; }
    bool has_cycle() const;
    uint8_t at(size_t i) const { return bytes_[(next_ + i) % bytes_.size()]; }

   private:
    bool marker_at(size_t i) const;
    std::array<uint8_t, kCycleBytes + kMarkerBytes> bytes_{};
    size_t next_ = 0;   ///< index of the oldest byte
    size_t count_ = 0;  ///< number of bytes so far
  };

  std::optional<Calibration> read(const Window& window) const;

  Model model_;
  Window with_warnings_;     ///< S3 firmware sends warning bits (type W) as a byte of the cycle
  Window without_warnings_;  ///< or in addition to it
};

}  // namespace infuse::velodyne
