#pragma once

#include <cstddef>
#include <span>

namespace infuse {

/// A sample of an envelope problem.
struct EnvelopePoint {
  double x = 0;
  double y = 0;
};

/// y = intercept + slope · x.
struct EnvelopeLine {
  double intercept = 0;
  double slope = 0;
};

/// Of all lines on or below every point with |slope| ≤ max_slope, the one closest to the points:
/// the sum of the vertical distances is least (Moon, Skelly and Towsley 1999). Of several, one.
/// `points`: at least one, x strictly increasing; they serve as room to work in and are left in
/// disorder. Linear in their number.
EnvelopeLine lower_envelope(std::span<EnvelopePoint> points, double max_slope);

}  // namespace infuse
