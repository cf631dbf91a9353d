#include <algorithm>

#include "fusion/features/ranks.hpp"
#include "fusion/monitoring/monitor_view.hpp"

namespace infuse::monitoring {
namespace {

constexpr double kContrastWidth = 8;  // samples, surroundings that a grey level is compared with
constexpr double kNoiseSigma = 2;     // grey levels, of a smooth surface
constexpr double kBlurSigma = 1;      // samples
// Samples: 1.1° of an image with a focal length of 300, so that peaks at steps of 3 and 6° are as
// wide as half the step between them.
constexpr double kCoarseBlur = 6;
constexpr int kCoarseStep = 4;  // samples; not more than the blur allows

}  // namespace

void PlaneBlur::compute(const ComparedPlanes& planes, double sigma, int step, ComparedPlanes& out) {
  out.step = planes.step;
  blur_.compute(planes.grey, sigma, step, out.grey);
  features::equalize_by_level(out.grey.values, 1);
  blur_.compute(planes.edge, sigma, step, out.edge);
  features::equalize_by_level(out.edge.values, 1);
}

void MonitorImage::build(const CameraFrame& grey, int step, const features::RingDirections& rings) {
  ComparedPlanes& fine = compared_.fine;
  fine.step = std::max(1, step);
  features::reduce_by_means(grey, fine.step, reduced_);
  ring_edge_.compute(reduced_, rings, raw_);
  features::equalize_by_level(raw_.values, 256);
  blur_.compute(raw_, kBlurSigma, 1, fine.edge);
  local_contrast_.compute(reduced_, kContrastWidth, kNoiseSigma, raw_);
  features::equalize_by_level(raw_.values, 1);
  blur_.compute(raw_, kBlurSigma, 1, fine.grey);
  plane_blur_.compute(fine, kCoarseBlur, kCoarseStep, compared_.coarse);
}

}  // namespace infuse::monitoring
