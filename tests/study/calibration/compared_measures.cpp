#include "tests/study/calibration/compared_measures.hpp"

#include <vector>

#include "tests/study/calibration/correlation_term.hpp"

namespace infuse::study {
namespace {

using calibration::ImageFeature;
using calibration::LidarFeature;
using calibration::NamedMeasure;
using calibration::TermOptions;

TermOptions normalised(LidarFeature lidar, ImageFeature image) {
  return {.measure = calibration::Measure::kNormalisedMutualInformation,
          .lidar = {lidar},
          .image = {image},
          .bins = 32,
          .equalize = false};
}

std::vector<NamedMeasure> make_measures() {
  return {
      {.name = "nmi",
       .description = "normalised mutual information, I(4.2)",
       .terms = {normalised(LidarFeature::kRelativeReflectivity, ImageFeature::kLocalGrey)}},
      {.name = "nmi-raw",
       .description = "the same of reflectivity and grey as the sensors state them",
       .terms = {normalised(LidarFeature::kReflectivity, ImageFeature::kGrey)}},
      {.name = "levinson-thrun",
       .description = "depth edges times image edges, P(3.23), I(4.4)",
       .terms = {{.lidar = {LidarFeature::kDiscontinuity},
                  .image = {ImageFeature::kEdge},
                  .equalize = false,
                  .make = make_correlation_term}}},
  };
}

}  // namespace

std::span<const NamedMeasure> compared_measures() {
  static const std::vector<NamedMeasure> measures = make_measures();
  return measures;
}

const NamedMeasure* find_any_measure(const std::string& name) {
  if (const NamedMeasure* named = calibration::find_measure(name)) return named;
  for (const NamedMeasure& measure : compared_measures()) {
    if (measure.name == name) return &measure;
  }
  return nullptr;
}

}  // namespace infuse::study
