#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "drivers/velodyne/calibration.hpp"

namespace infuse::velodyne {

/// Gathers an HDL-64E's calibration from the last two bytes of successive packets: (type, value)
/// pairs, of which those of a clock, GPS, temperature and firmware are not wanted and the rest is
/// an 1820-byte cycle: "UNIT#", 2 bytes, 64 records of 21 bytes every 28, 26 bytes; on an S3 the
/// last two are a CRC-16. A cycle takes 4160 packets, 1.2 to 1.5 seconds.
class CalibrationStream {
 public:
  /// `model` is one of the HDL-64E's.
  explicit CalibrationStream(Model model) : model_(model) {}

  /// Takes a packet's bytes 1204 and 1205. The calibration, when a cycle is complete and whole: it
  /// begins and ends with "UNIT#", its records are numbered 0 … 63, its numbers are possible and,
  /// on an S3, its checksum fits.
  std::optional<Calibration> add(uint8_t type, uint8_t value);

  /// Packets are missing: what was gathered is worth nothing.
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
    size_t next_ = 0;   ///< place of the oldest byte
    size_t count_ = 0;  ///< bytes so far
  };

  std::optional<Calibration> read(const Window& window) const;

  Model model_;
  Window with_warnings_;     ///< S3 firmware sends warning bits (type W) as a byte of the cycle
  Window without_warnings_;  ///< or beside it
};

}  // namespace infuse::velodyne
