#pragma once

#include <cmath>

namespace infuse::geometry {

/// Length of the vector (x, y). Unlike hypot of the C library, whose last bit differs between
/// processors, it is made of operations that round alike on all. No length here is near the limits
/// of double, for which hypot takes care.
inline double plane_length(double x, double y) { return std::sqrt(x * x + y * y); }

}  // namespace infuse::geometry
