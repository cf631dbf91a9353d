#include "drivers/velodyne/beam_origins.hpp"

#include <cmath>

namespace infuse::velodyne {

double crossing_distance(Model model) {
  switch (model) {
    case Model::kHdl32e:
      return 0.0290;
    case Model::kVlp16:
    case Model::kPuckHiRes:
      return 0.0419;
    case Model::kVlp32c:
      return 0.0424;
    case Model::kVls128:
      return 0.05863;
    case Model::kHdl64eS2:
    case Model::kHdl64eS3:
      break;
  }
  return 0;
}

void add_beam_origins(Calibration& calibration, const ModelInfo& info) {
  const double distance = crossing_distance(info.model);
  for (size_t laser = 0; laser < info.lasers; ++laser) {
    BeamCorrection& beam = calibration.beams[laser];
    beam.vertical_offset = -distance * std::tan(beam.elevation);
  }
}

Calibration single_origin_calibration(Model model) {
  Calibration calibration = built_in_calibration(model);
  if (model_info(model).calibrated_per_unit) return calibration;
  for (BeamCorrection& beam : calibration.beams) beam.vertical_offset = 0;
  return calibration;
}

}  // namespace infuse::velodyne
