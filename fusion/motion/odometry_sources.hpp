#pragma once

#include <array>
#include <cstdint>

#include "fusion/motion/odometry_options.hpp"

namespace infuse::motion {

/// Sources of odometry.
enum class OdometrySource : uint8_t {
  kWheels,
  kSpeed,  ///< one speed of the vehicle, whatever measures it
  kYawRate,
  kGyro,
  kGnssSpeed,
  kGnssCourse,
  kGnssPosition,  ///< checked, never used
  kLidar,
  kCount,
};
inline constexpr size_t kOdometrySources = static_cast<size_t>(OdometrySource::kCount);

/// Names of the sources, in their order.
inline constexpr std::array<const char*, kOdometrySources> kOdometrySourceNames = {
    "wheels", "speed", "yaw rate", "gyro", "gnss speed", "gnss course", "gnss position", "lidar"};

/// Standard deviations of its difference to the motion beyond which a sample is rejected.
inline constexpr double kGateSigmas = 4;

/// What became of the samples of one source.
struct SourceRecord {
  uint64_t accepted = 0;
  uint64_t rejected = 0;                    ///< inconsistent with the motion, in part at least
  Stamp last_accepted = Stamp::earliest();  ///< earliest: none
  Stamp last_speed = Stamp::earliest();     ///< that measured the speed, if the source does
  Stamp last_rotation = Stamp::earliest();  ///< that measured the rotation about z, the same
  Stamp rejected_since = Stamp::latest();   ///< latest: the last sample was accepted
  uint64_t rejected_in_a_row = 0;
};

/// Supervision of the sources: which of them carry the odometry now.
class OdometrySources {
 public:
  explicit OdometrySources(const OdometryOptions& options) : options_(options) {}

  /// Records a sample of a source. A lidar does not always measure both: in a tunnel no speed.
  void add(OdometrySource source, bool accepted, Stamp now, bool speed = true,
           bool rotation = true);

  /// Counts the last sample, which was accepted, as rejected: in part it was.
  void reject_part(OdometrySource source) {
    SourceRecord& record = records_[static_cast<size_t>(source)];
    --record.accepted;
    ++record.rejected;
  }

  /// Lets a source carry on without a sample, which is not counted.
  void hold(OdometrySource source, Stamp now) {
    SourceRecord& record = records_[static_cast<size_t>(source)];
    record.last_accepted = record.last_speed = record.last_rotation = now;
  }

  /// Forgets when samples came; the counters stay.
  void reset();

  const SourceRecord& operator[](OdometrySource source) const {
    return records_[static_cast<size_t>(source)];
  }

  /// Returns true if a sample of the source was accepted recently.
  bool carries(OdometrySource source, Stamp now) const;

  /// Returns true if the source measured the speed recently.
  bool measures_speed(OdometrySource source, Stamp now) const {
    return is_recent(source, (*this)[source].last_speed, now);
  }
  /// Returns true if a source carries the speed; `except` is not asked.
  bool speed_known(Stamp now, OdometrySource except = OdometrySource::kCount) const;
  /// Returns true if a source carries the rotation about z; `except` is not asked.
  bool rotation_known(Stamp now, OdometrySource except = OdometrySource::kCount) const;

 private:
  bool is_recent(OdometrySource source, Stamp last, Stamp now) const;

  OdometryOptions options_;
  std::array<SourceRecord, kOdometrySources> records_;
};

}  // namespace infuse::motion
