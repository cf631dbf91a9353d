#include <cmath>
#include <cstdlib>
#include <string_view>

#include "drivers/import/ford_files.hpp"

// Any bytes as a MAT-file, and its variables as cameras and poses; as stamps; as an image's header.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace infuse;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  std::vector<Error> notes;
  for (const Stamp stamp : importers::parse_ford_stamps(text, "fuzz", notes)) {
    if (stamp < Stamp()) std::abort();
  }
  if (const auto header = importers::read_pnm_header(text)) {
    if (header->width <= 0 || header->height <= 0 || header->pixels >= size) std::abort();
  }
  const auto variables = importers::read_mat({data, size}, "fuzz");
  if (!variables) {
    if (variables.error().what.empty()) std::abort();
    return 0;
  }
  for (const auto& [name, array] : *variables) {
    if (!array.numbers.empty() && array.numbers.size() != array.rows * array.columns) std::abort();
  }
  if (const auto cameras = importers::read_ford_cameras(*variables, "fuzz")) {
    for (const auto& camera : *cameras) {
      if (!camera.T_camera_velodyne.matrix().allFinite()) std::abort();
    }
  }
  if (const auto scan = importers::read_ford_scan(*variables, "fuzz")) {
    if (!scan->T_local_body.matrix().allFinite()) std::abort();
  }
  if (const auto poses = importers::read_ford_poses(*variables, "fuzz")) {
    for (const auto& pose : *poses) {
      if (!pose.T_local_body.matrix().allFinite()) std::abort();
    }
  }
  return 0;
}
