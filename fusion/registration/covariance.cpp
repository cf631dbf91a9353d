#include "fusion/registration/covariance.hpp"

#include <algorithm>
#include <array>

#include "drivers/measurement/simd.hpp"

namespace infuse::registration {
namespace {

constexpr int kPoints = 8;  // doubles side by side

/// Upper triangles of eight symmetric 3 × 3 matrices: xx, xy, xz, yy, yz, zz.
using Matrices = std::array<Doubles, 6>;

/// Smallest eigenvalue of a positive semidefinite matrix: Newton's method on the characteristic
/// polynomial from 0, from where it rises to the smallest root without passing it.
[[gnu::always_inline]] inline Doubles smallest_eigenvalue(const Doubles& trace,
                                                          const Doubles& minors,
                                                          const Doubles& determinant) {
  Doubles value = {};
  for (int i = 0; i < 8; ++i) {
    const Doubles polynomial = ((trace - value) * value - minors) * value + determinant;
    const Doubles slope = (2 * trace - 3 * value) * value - minors;
    const Doubles step = slope < 0 ? polynomial / slope : Doubles{};
    value -= step;
  }
  return value;
}

/// Eigenvectors of the smallest eigenvalue: the longest cross product of two rows of A − λ.
/// (0, 0, 0) where the second variance is below `min_spread` of the first.
INFUSE_SIMD_CLONES void plane_normals(const Matrices& matrices, double min_spread,
                                      std::array<Doubles, 3>& normals) {
  const auto& [axx, axy, axz, ayy, ayz, azz] = matrices;
  const Doubles trace = axx + ayy + azz;
  const Doubles minors = axx * ayy - axy * axy + axx * azz - axz * axz + ayy * azz - ayz * ayz;
  const Doubles determinant =
      axx * (ayy * azz - ayz * ayz) - axy * (axy * azz - ayz * axz) + axz * (axy * ayz - ayy * axz);
  const Doubles value = smallest_eigenvalue(trace, minors, determinant);
  const Doubles bxx = axx - value, byy = ayy - value, bzz = azz - value;
  const Doubles cross[3][3] = {
      {axy * ayz - axz * byy, axz * axy - bxx * ayz, bxx * byy - axy * axy},  // rows 0 and 1
      {axy * bzz - axz * ayz, axz * axz - bxx * bzz, bxx * ayz - axy * axz},  // rows 0 and 2
      {byy * bzz - ayz * ayz, ayz * axz - axy * bzz, axy * ayz - byy * axz},  // rows 1 and 2
  };
  Doubles longest = {}, nx = {}, ny = {}, nz = {};
  for (const auto& c : cross) {
    const Doubles square = c[0] * c[0] + c[1] * c[1] + c[2] * c[2];
    const auto longer = square > longest;
    longest = longer ? square : longest;
    nx = longer ? c[0] : nx;
    ny = longer ? c[1] : ny;
    nz = longer ? c[2] : nz;
  }
  // The other two eigenvalues: their sum is trace − λ, their product minors − λ (trace − λ).
  const Doubles sum = trace - value;
  const Doubles product = minors - value * sum;
  const auto flat = (product > min_spread * sum * sum) & (longest > 0);
  Doubles root;
  for (int i = 0; i < kPoints; ++i) root[i] = __builtin_sqrt(longest[i]);
  const Doubles scale = flat ? 1 / root : Doubles{};
  normals = {nx * scale, ny * scale, nz * scale};
}

/// Covariance of the neighbours of a point, relative to it; zero if there are too few.
void add_neighbourhood(const NeighbourSearch& search, const CovarianceOptions& options,
                       const PointCloud& cloud, size_t i, int lane, Matrices& matrices) {
  std::array<int32_t, NeighbourSearch::kMaxNeighbours> indices;
  std::array<float, NeighbourSearch::kMaxNeighbours> squares;
  const float point[3] = {cloud.x[i], cloud.y[i], cloud.z[i]};
  const int count =
      search.nearest_neighbours(point, options.neighbours, indices.data(), squares.data());
  for (Doubles& entry : matrices) entry[lane] = 0;
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
    matrices[e][lane] = (cross[e] - sum[kRow[e]] * sum[kColumn[e]] / count) / count;
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
  // Ratio r of two variances to a bound of their product by the square of their sum.
  const double ratio = options.min_spread;
  const double min_spread = ratio / ((1 + ratio) * (1 + ratio));
  for (size_t begin = 0; begin < cloud.size(); begin += kPoints) {
    const int count = static_cast<int>(std::min<size_t>(kPoints, cloud.size() - begin));
    Matrices matrices = {};
    for (int lane = 0; lane < count; ++lane) {
      add_neighbourhood(search, options, cloud, begin + static_cast<size_t>(lane), lane, matrices);
    }
    std::array<Doubles, 3> normals;
    plane_normals(matrices, min_spread, normals);
    for (int lane = 0; lane < count; ++lane) {
      const size_t i = begin + static_cast<size_t>(lane);
      cloud.nx[i] = static_cast<float>(normals[0][lane]);
      cloud.ny[i] = static_cast<float>(normals[1][lane]);
      cloud.nz[i] = static_cast<float>(normals[2][lane]);
    }
  }
}

}  // namespace infuse::registration
