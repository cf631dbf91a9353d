#include "drivers/measurement/lower_envelope.hpp"

#include <algorithm>
#include <cmath>

namespace infuse {
namespace {

/// True if b lies below the line from a to c (all in order of x).
bool is_below(const EnvelopePoint& a, const EnvelopePoint& b, const EnvelopePoint& c) {
  return (b.y - a.y) * (c.x - a.x) < (c.y - a.y) * (b.x - a.x);
}

/// Moves the corners of the lower convex hull to the front (Andrew's monotone chain).
std::span<EnvelopePoint> lower_hull(std::span<EnvelopePoint> points) {
  size_t corners = 0;
  for (const EnvelopePoint point : points) {
    while (corners >= 2 && !is_below(points[corners - 2], points[corners - 1], point)) --corners;
    points[corners++] = point;
  }
  return points.first(corners);
}

}  // namespace

EnvelopeLine lower_envelope(std::span<EnvelopePoint> points, double max_slope) {
  double mean_x = 0;
  for (const EnvelopePoint& point : points) mean_x += point.x;
  mean_x /= static_cast<double>(points.size());

  // A line below all points is highest at the mean of x, and so has the smallest sum of distances,
  // if it contains the hull's edge over that mean. The height is concave in the slope, so clamping
  // the slope is optimal.
  const std::span<EnvelopePoint> hull = lower_hull(points);
  double slope = 0;
  if (hull.size() >= 2) {
    size_t end = 1;
    while (end + 1 < hull.size() && hull[end].x < mean_x) ++end;
    slope = (hull[end].y - hull[end - 1].y) / (hull[end].x - hull[end - 1].x);
    slope = std::clamp(slope, -max_slope, max_slope);
  }
  double intercept = hull[0].y - slope * hull[0].x;
  for (const EnvelopePoint& corner : hull) {
    intercept = std::min(intercept, corner.y - slope * corner.x);
  }
  return {.intercept = intercept, .slope = slope};
}

}  // namespace infuse
