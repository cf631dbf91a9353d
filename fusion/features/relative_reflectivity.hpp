#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace infuse::features {

/// Reflectivity of returns as a rank among the returns of the same beam at like range (within a
/// quarter of an octave), 0 … 1; equal values share the mean of their ranks.
///
/// Reflectivity as a sensor states it differs by beam, and falls with range and with the angle at
/// which the road is met. The rows of an image go with range as well, so the fall is dependence
/// too, but one that shifts the maximum: on simulated streets, where the truth is known, mutual
/// information of plain reflectivity has no maximum at the truth at all. A rank removes any
/// monotone response, and so does the work of a cross-beam calibration (Levinson and Thrun's,
/// unsupervised: all beams see the same world) and of a fitted range response (I 4.3.1.1) without a
/// model of either.
///
/// Allocates nothing after its first sweep of a size.
class RelativeReflectivity {
 public:
  /// Returns one rank per return. One entry a return in each argument: `range` in m, `reflectivity`
  /// 0 … 1, compared as the 8 bits that sensors state. Valid until the next call.
  const std::vector<float>& compute(std::span<const uint16_t> ring, std::span<const float> range,
                                    std::span<const float> reflectivity);

 private:
  std::vector<uint32_t> size_;   ///< number of returns by group of beam and range
  std::vector<uint32_t> count_;  ///< by group and level; all 0 between calls
  std::vector<float> rank_;      ///< by group and level
  std::vector<uint32_t> cell_;   ///< group and level of each return
  std::vector<float> relative_;
};

}  // namespace infuse::features
