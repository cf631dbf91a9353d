#pragma once

#include "drivers/velodyne/decoder.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"

#include <stdexcept>

#include "tests/drivers/velodyne/oracle.hpp"

namespace infuse::velodyne {

inline Scene make_model_scene(Model model, SceneOptions options = {}) {
  options.model = model;
  options.calibration = built_in_calibration(model);
  return make_scene(options);
}

inline size_t count_returns(const std::vector<Sweep>& sweeps) {
  size_t sum = 0;
  for (const Sweep& sweep : sweeps) sum += sweep.size();
  return sum;
}

inline bool same_returns(const Sweep& a, const Sweep& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z && a.range == b.range && a.ring == b.ring &&
         a.column == b.column && a.time_offset_ns == b.time_offset_ns &&
         a.return_kind == b.return_kind && a.reflectivity == b.reflectivity;
}

}  // namespace infuse::velodyne
