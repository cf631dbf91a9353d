#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "drivers/measurement/stamp.hpp"

namespace infuse::lidar {

/// Follows the packets of one address by their counters and azimuths: a sensor turns steadily, so
/// both show where its next packet begins. Packets of two sensors behind one address form two
/// tracks.
class PacketTracks {
 public:
  /// Place of a packet in its track.
  struct Step {
    int64_t period_us = 0;  ///< since the track's previous packet; 0: the track begins
    int advance = 0;        ///< 0.01°, turned in that time
  };

  /// `modulo`: time after which the device's counter wraps; 0: never.
  explicit PacketTracks(Duration modulo) : modulo_(modulo) {}

  /// Adds a packet by its counter (whole microseconds count) and its first azimuth (0.01°).
  Step add(Duration counter, int azimuth);

  /// Number of packets that followed a packet of another track, both tracks being established: half
  /// of all if two sensors alternate, a few after a restart.
  uint64_t alternations() const { return alternations_; }

  /// True if so many alternate that there are two sensors.
  bool alternate() const { return alternations_ >= 20 && alternations_ * 20 >= packets_; }

 private:
  /// The latest packet of one sensor.
  struct Track {
    Duration counter{0};
    int azimuth = 0;      // 0.01°
    double rate = 0;      // 0.01° per µs; valid from the second packet on
    uint64_t count = 0;   // packets; 0: unused
    uint64_t latest = 0;  // number of its latest packet among all
  };

  std::optional<Step> step_from(const Track& track, Duration counter, int azimuth) const;
  static void extend(Track& track, const Step& step, Duration counter, int azimuth);

  Duration modulo_;
  std::array<Track, 4> tracks_{};
  size_t current_ = 0;
  uint64_t packets_ = 0;
  uint64_t alternations_ = 0;
};

}  // namespace infuse::lidar
