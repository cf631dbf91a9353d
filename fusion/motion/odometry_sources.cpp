#include "fusion/motion/odometry_sources.hpp"

#include <algorithm>

namespace infuse::motion {
namespace {

constexpr OdometrySource kSpeedSources[] = {OdometrySource::kWheels, OdometrySource::kSpeed,
                                            OdometrySource::kGnssSpeed, OdometrySource::kLidar};
constexpr OdometrySource kRotationSources[] = {OdometrySource::kYawRate, OdometrySource::kGyro,
                                               OdometrySource::kGnssCourse, OdometrySource::kLidar};

bool is_gnss(OdometrySource source) {
  return source == OdometrySource::kGnssSpeed || source == OdometrySource::kGnssCourse ||
         source == OdometrySource::kGnssPosition;
}

}  // namespace

void OdometrySources::add(OdometrySource source, bool accepted, Stamp now, bool speed,
                          bool rotation) {
  SourceRecord& record = records_[static_cast<size_t>(source)];
  if (accepted) {
    ++record.accepted;
    record.last_accepted = now;
    if (speed) record.last_speed = now;
    if (rotation) record.last_rotation = now;
    record.rejected_since = Stamp::latest();
    record.rejected_in_a_row = 0;
  } else {
    ++record.rejected;
    ++record.rejected_in_a_row;
    record.rejected_since = std::min(record.rejected_since, now);
  }
}

void OdometrySources::reset() {
  for (SourceRecord& record : records_) {
    record.last_accepted = record.last_speed = record.last_rotation = Stamp::earliest();
    record.rejected_since = Stamp::latest();
    record.rejected_in_a_row = 0;
  }
}

bool OdometrySources::is_recent(OdometrySource source, Stamp last, Stamp now) const {
  return last != Stamp::earliest() &&
         now - last <= (is_gnss(source) ? options_.max_gnss_silence : options_.max_silence);
}

bool OdometrySources::carries(OdometrySource source, Stamp now) const {
  return is_recent(source, (*this)[source].last_accepted, now);
}

bool OdometrySources::speed_known(Stamp now, OdometrySource except) const {
  return std::any_of(std::begin(kSpeedSources), std::end(kSpeedSources),
                     [&](OdometrySource s) { return s != except && measures_speed(s, now); });
}

bool OdometrySources::rotation_known(Stamp now, OdometrySource except) const {
  return std::any_of(
      std::begin(kRotationSources), std::end(kRotationSources),
      [&](OdometrySource s) { return s != except && is_recent(s, (*this)[s].last_rotation, now); });
}

}  // namespace infuse::motion
