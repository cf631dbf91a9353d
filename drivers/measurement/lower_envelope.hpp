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

/// Returns the line on or below every point, with |slope| ≤ max_slope, that has the smallest sum of
/// vertical distances to the points (Moon, Skelly and Towsley 1999); one of them if there are
/// several. `points`: at least one, x strictly increasing; they are reordered. Linear in their
/// number.
EnvelopeLine lower_envelope(std::span<EnvelopePoint> points, double max_slope);

}  // namespace infuse
