#include "fusion/registration/prepared_cloud.hpp"

#include <algorithm>

#include "fusion/registration/lengths.hpp"

namespace infuse::registration {

void build_and_sort(PointCloud& cloud, NeighbourSearch& search) {
  search.build_and_sort(cloud.x, cloud.y, cloud.z);
  cloud.resize(search.size());
  for (FieldVector<float>* field : {&cloud.nx, &cloud.ny, &cloud.nz}) {
    std::fill(field->begin(), field->end(), 0.0F);
  }
}

std::optional<std::string> PrepareOptions::invalid() const {
  if (!(voxel_size >= 0 && voxel_size < 100)) return "voxel_size must be between 0 and 100 m";
  return covariance.invalid();
}

PrepareOptions sweep_options(double voxel_size) {
  PrepareOptions options;
  options.voxel_size = voxel_size;
  options.covariance.min_incidence = kMinIncidence;
  return options;
}

void CloudPreparer::prepare(const geometry::PointsView& points, const PrepareOptions& options,
                            PreparedCloud& out) {
  constexpr double kDistinct = 1e-3;  // m; copies alone: ranges have steps of 2 mm (HDL-32E manual)
  downsampler_.compute(points, options.voxel_size > 0 ? options.voxel_size : kDistinct, out.cloud);
  build_and_sort(out.cloud, out.search);
  estimate_covariances(out.search, options.covariance, candidates_, out.cloud);
}

PreparedCloud prepare_cloud(const geometry::PointsView& points, const PrepareOptions& options) {
  PreparedCloud out;
  CloudPreparer().prepare(points, options, out);
  return out;
}

}  // namespace infuse::registration
