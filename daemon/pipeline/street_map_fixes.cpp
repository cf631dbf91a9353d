#include "daemon/pipeline/street_map_fixes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "drivers/measurement/angles.hpp"
#include "drivers/measurement/median.hpp"

namespace infuse::daemon {
namespace {

constexpr size_t kMaxFixes = 64;
constexpr size_t kMinInitialFixes = 5;
constexpr Duration kInitialWindow{10'000'000'000};  // ns of the fixes of an initial pose
constexpr double kMaxInitialHdop = 5;
constexpr double kMinCourseSpeed = 2.0;  // m/s above which the GNSS course is the heading

using Values = std::array<double, kMaxFixes>;

double median_of(Values& values, size_t count) { return median(std::span(values).first(count)); }

/// Motion in the plane; nothing if the trajectory does not connect the times.
std::optional<streetmap::PlanarPose> motion_between(const geometry::Trajectory& trajectory,
                                                    Stamp from, Stamp to) {
  if (from == to) return streetmap::PlanarPose{};
  const geometry::MotionBetween motion = trajectory.between(from, to);
  if (!motion.usable()) return std::nullopt;
  const Eigen::Isometry3d& T = motion.T_from_to;
  return streetmap::PlanarPose{T.translation().x(), T.translation().y(),
                               std::atan2(T(1, 0), T(0, 0))};
}

}  // namespace

StreetMapFixes::StreetMapFixes(const gnss::LocalFrame& frame) : frame_(frame) {
  fixes_.reserve(kMaxFixes);
}

void StreetMapFixes::add(const GnssFix& fix) {
  if (!fix.valid || !std::isfinite(fix.latitude) || !std::isfinite(fix.longitude)) return;
  if (fixes_.size() == kMaxFixes) {
    fixes_.erase(fixes_.begin());
    next_ -= next_ > 0 ? 1 : 0;
  }
  Fix added{fix.stamp, gnss::to_local(frame_, fix.latitude, fix.longitude).head<2>(), {}, fix.hdop};
  if (std::isfinite(fix.course) && fix.speed >= kMinCourseSpeed) {
    added.yaw = wrap_angle(std::numbers::pi / 2 - fix.course);
  }
  fixes_.push_back(added);
}

std::optional<streetmap::MapFix> StreetMapFixes::take(Stamp now, double yaw,
                                                      const geometry::Trajectory& trajectory) {
  while (next_ < fixes_.size() && fixes_[next_].stamp <= now) {
    const Fix& fix = fixes_[next_++];
    const auto motion = motion_between(trajectory, fix.stamp, now);
    if (!motion) continue;
    const double heading = fix.yaw.value_or(yaw - motion->yaw);
    const streetmap::PlanarPose at{fix.position.x(), fix.position.y(), heading};
    streetmap::MapFix moved;
    moved.position = at.transform({motion->x, motion->y});
    if (fix.yaw) moved.yaw = wrap_angle(*fix.yaw + motion->yaw);
    moved.hdop = fix.hdop;
    return moved;
  }
  return std::nullopt;
}

std::optional<InitialPoseFromFixes> StreetMapFixes::initial_pose(
    Stamp now, const geometry::Trajectory& trajectory) const {
  // Of each fix: the motion from it to now; where its course is known, the heading now.
  std::array<std::pair<const Fix*, streetmap::PlanarPose>, kMaxFixes> moved;
  size_t count = 0, courses = 0;
  double cosine = 0, sine = 0;
  Values hdops;
  for (const Fix& fix : fixes_) {
    if (fix.stamp > now || fix.stamp + kInitialWindow < now || fix.hdop > kMaxInitialHdop) continue;
    const auto motion = motion_between(trajectory, fix.stamp, now);
    if (!motion) continue;
    hdops[count] = fix.hdop > 0 ? fix.hdop : streetmap::GnssOptions().unknown_hdop;
    moved[count++] = {&fix, *motion};
    if (!fix.yaw) continue;
    ++courses;
    cosine += std::cos(*fix.yaw + motion->yaw);
    sine += std::sin(*fix.yaw + motion->yaw);
  }
  if (count < kMinInitialFixes || courses < kMinInitialFixes) return std::nullopt;
  const double yaw = std::atan2(sine, cosine);
  Values x, y;
  for (size_t i = 0; i < count; ++i) {
    const auto& [fix, motion] = moved[i];
    const Eigen::Vector2d place =
        streetmap::PlanarPose{fix->position.x(), fix->position.y(), yaw - motion.yaw}.transform(
            {motion.x, motion.y});
    x[i] = place.x();
    y[i] = place.y();
  }
  return InitialPoseFromFixes{{median_of(x, count), median_of(y, count), yaw},
                              median_of(hdops, count)};
}

}  // namespace infuse::daemon
