#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace infuse::calibration {

/// Every return's reflectivity by rank among the returns of its own beam at like range (within a
/// quarter of an octave), 0 … 1; equal values share the mean of their ranks.
///
/// Reflectivity as a sensor states it differs by beam, and falls with range and with the angle at
/// which the road is met. A picture's rows go with range as well, so the fall is dependence too,
/// but of a kind that pulls a calibration away from the truth: on simulated streets, where the
/// truth is known, mutual information of reflectivity as it is has no maximum there at all. A rank
/// among its like takes out any monotone response, and so does the work of a cross-beam calibration
/// (Levinson and Thrun's, unsupervised: all beams see the same world) and of a fitted range
/// response (I 4.3.1.1) without a model of either. Keeps its memory.
class RelativeReflectivity {
 public:
  /// One entry a return in all of `ring`, `range` (m) and `reflectivity` (0 … 1, compared as the 8
  /// bits that sensors state). Valid until the next call.
  const std::vector<float>& compute(std::span<const uint16_t> ring, std::span<const float> range,
                                    std::span<const float> reflectivity);

 private:
  std::vector<uint32_t> size_;   ///< by group of beam and range
  std::vector<uint32_t> count_;  ///< by group and level; all 0 between calls
  std::vector<float> rank_;      ///< likewise
  std::vector<uint32_t> cell_;   ///< of each return
  std::vector<float> relative_;
};

}  // namespace infuse::calibration
