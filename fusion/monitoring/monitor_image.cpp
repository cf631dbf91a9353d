#include <algorithm>

#include "fusion/features/ranks.hpp"
#include "fusion/monitoring/monitor_view.hpp"

namespace infuse::monitoring {
namespace {

constexpr double kContrastWidth = 8;  // samples, surroundings that a grey level is compared with
constexpr double kNoiseSigma = 2;     // grey levels, of a smooth surface
constexpr double kBlurSigma = 1;      // samples

}  // namespace

void MonitorImage::build(const CameraFrame& grey, int step, const features::RingDirections& rings) {
  step_ = std::max(1, step);
  features::reduce_by_means(grey, step_, reduced_);
  ring_edge_.compute(reduced_, rings, raw_);
  features::equalize_by_level(raw_.values, 256);
  blur_.compute(raw_, kBlurSigma, 1, edge_);
  local_contrast_.compute(reduced_, kContrastWidth, kNoiseSigma, raw_);
  features::equalize_by_level(raw_.values, 1);
  blur_.compute(raw_, kBlurSigma, 1, grey_);
}

}  // namespace infuse::monitoring
