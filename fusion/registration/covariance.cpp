#include "fusion/registration/covariance.hpp"

#include <algorithm>
#include <array>

#include "fusion/registration/plane_fit.hpp"

namespace infuse::registration {
namespace {

/// Covariance of the neighbours of a point, relative to it; zero if there are too few.
void add_neighbourhood(const NeighbourSearch& search, const CovarianceOptions& options,
                       const PointCloud& cloud, size_t i, int lane, Covariances& covariances) {
  std::array<int32_t, NeighbourSearch::kMaxNeighbours> indices;
  std::array<float, NeighbourSearch::kMaxNeighbours> squares;
  const float point[3] = {cloud.x[i], cloud.y[i], cloud.z[i]};
  const int count =
      search.nearest_neighbours(point, options.neighbours, indices.data(), squares.data());
  for (Doubles& entry : covariances) entry[lane] = 0;
  if (count < options.min_neighbours) return;
  double sum[3] = {}, cross[6] = {};
  for (int k = 0; k < count; ++k) {
    const auto j = static_cast<size_t>(indices[static_cast<size_t>(k)]);
    const double x = cloud.x[j] - point[0], y = cloud.y[j] - point[1], z = cloud.z[j] - point[2];
    sum[0] += x, sum[1] += y, sum[2] += z;
    cross[0] += x * x, cross[1] += x * y, cross[2] += x * z;
    cross[3] += y * y, cross[4] += y * z, cross[5] += z * z;
  }
  constexpr int kRow[6] = {0, 0, 0, 1, 1, 2}, kColumn[6] = {0, 1, 2, 1, 2, 2};
  for (size_t e = 0; e < 6; ++e) {
    covariances[e][lane] = (cross[e] - sum[kRow[e]] * sum[kColumn[e]] / count) / count;
  }
}

}  // namespace

std::optional<std::string> CovarianceOptions::invalid() const {
  if (neighbours < 3 || neighbours > NeighbourSearch::kMaxNeighbours)
    return "neighbours must be 3 ... " + std::to_string(NeighbourSearch::kMaxNeighbours);
  if (min_neighbours < 3 || min_neighbours > neighbours)
    return "min_neighbours must be 3 ... neighbours";
  if (!(min_spread >= 0 && min_spread < 1)) return "min_spread must be 0 ... 1";
  return std::nullopt;
}

void estimate_covariances(const NeighbourSearch& search, const CovarianceOptions& options,
                          PointCloud& cloud) {
  for (size_t begin = 0; begin < cloud.size(); begin += kPlanes) {
    const int count = static_cast<int>(std::min<size_t>(kPlanes, cloud.size() - begin));
    Covariances covariances = {};
    for (int lane = 0; lane < count; ++lane) {
      add_neighbourhood(search, options, cloud, begin + static_cast<size_t>(lane), lane,
                        covariances);
    }
    const PlaneFits planes = fit_planes(covariances, options.min_spread);
    for (int lane = 0; lane < count; ++lane) {
      const size_t i = begin + static_cast<size_t>(lane);
      cloud.nx[i] = static_cast<float>(planes.normal[0][lane]);
      cloud.ny[i] = static_cast<float>(planes.normal[1][lane]);
      cloud.nz[i] = static_cast<float>(planes.normal[2][lane]);
    }
  }
}

}  // namespace infuse::registration
