#include "fusion/registration/covariance.hpp"

#include <Eigen/Core>
#include <cmath>

#include "fusion/registration/plane_fit.hpp"

namespace infuse::registration {
namespace {

using features::Neighbourhoods;

/// Covariances of `kPlanes` neighbourhoods from lane `first` on; zero where there are too few
/// points.
Covariances covariances_of(const Neighbourhoods& around, int first, int min_neighbours) {
  constexpr int kRow[6] = {0, 0, 0, 1, 1, 2}, kColumn[6] = {0, 1, 2, 1, 2, 2};
  Covariances covariances = {};
  for (int lane = 0; lane < kPlanes; ++lane) {
    const int i = first + lane;
    const double count = around.count[i];
    if (count < min_neighbours) continue;
    for (size_t e = 0; e < 6; ++e) {
      const double product = static_cast<double>(around.sum[kRow[e]][i]) *
                             static_cast<double>(around.sum[kColumn[e]][i]);
      covariances[e][lane] = (static_cast<double>(around.cross[e][i]) - product / count) / count;
    }
  }
  return covariances;
}

/// Whether the plane of point i is not edge-on to the ray from the origin.
bool faces_origin(const Eigen::Vector3d& normal, const PointCloud& cloud, size_t i,
                  double min_incidence) {
  const Eigen::Vector3d ray = Eigen::Vector3f(cloud.x[i], cloud.y[i], cloud.z[i]).cast<double>();
  return std::abs(normal.dot(ray)) >= min_incidence * ray.norm();
}

}  // namespace

std::optional<std::string> CovarianceOptions::invalid() const {
  if (neighbours < 3 || neighbours > NeighbourSearch::kMaxNeighbours)
    return "neighbours must be between 3 and " + std::to_string(NeighbourSearch::kMaxNeighbours);
  if (min_neighbours < 3 || min_neighbours > neighbours)
    return "min_neighbours must be between 3 and neighbours";
  if (!(min_incidence >= 0 && min_incidence < 1)) return "min_incidence must be between 0 and 1";
  return std::nullopt;
}

void estimate_covariances(const NeighbourSearch& search, const CovarianceOptions& options,
                          std::vector<NeighbourSearch::Point>& memory, PointCloud& cloud) {
  for (const NeighbourSearch::Leaf& leaf : search.leaves()) {
    const Neighbourhoods around = search.neighbourhoods(leaf, options.neighbours, memory);
    for (int first = 0; first < features::kLanes; first += kPlanes) {
      const PlaneFits planes = fit_planes(covariances_of(around, first, options.min_neighbours), 0);
      for (int lane = 0; lane < kPlanes; ++lane) {
        if (leaf.index[first + lane] < 0) continue;
        const auto i = static_cast<size_t>(leaf.index[first + lane]);
        const Eigen::Vector3d normal(planes.normal[0][lane], planes.normal[1][lane],
                                     planes.normal[2][lane]);
        const bool seen = faces_origin(normal, cloud, i, options.min_incidence);
        cloud.nx[i] = seen ? static_cast<float>(normal.x()) : 0;
        cloud.ny[i] = seen ? static_cast<float>(normal.y()) : 0;
        cloud.nz[i] = seen ? static_cast<float>(normal.z()) : 0;
      }
    }
  }
}

}  // namespace infuse::registration
