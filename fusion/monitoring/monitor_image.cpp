#include <algorithm>

#include "fusion/features/ranks.hpp"
#include "fusion/monitoring/monitor_view.hpp"

namespace infuse::monitoring {
namespace {

constexpr double kBlurSigma = 1;                                                  // samples
constexpr double kContrastWidth = features::kContrastWidthPerSigma * kBlurSigma;  // samples
// Samples: 1.1° of an image with a focal length of 300, so that peaks at steps of 3 and 6° are as
// wide as half the step between them: derived from `MonitorOptions::far_rotation_step`.
constexpr double kCoarseBlur = 6;
constexpr int kCoarseStep = 4;  // samples, derived from kCoarseBlur: the power of two below

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
  local_contrast_.compute(reduced_, kContrastWidth, features::kGreyNoise, raw_);
  features::equalize_by_level(raw_.values, 1);
  blur_.compute(raw_, kBlurSigma, 1, fine.grey);
  plane_blur_.compute(fine, kCoarseBlur, kCoarseStep, compared_.coarse);
}

}  // namespace infuse::monitoring
