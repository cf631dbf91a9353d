#pragma once

#include <algorithm>
#include <vector>

namespace infuse {

/// The value that this share of the values, of which there is one at least, does not reach.
inline double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1,
                         static_cast<size_t>(share * static_cast<double>(values.size())))];
}

}  // namespace infuse
