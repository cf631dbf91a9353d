#include "fusion/places/place_descriptor.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "drivers/measurement/angles.hpp"
#include "fusion/places/ground_height.hpp"

namespace infuse::places {
PlaceDescriptor describe_place(const geometry::PointsView& points,
                               const Eigen::Isometry3d& T_vehicle_lidar) {
  std::vector<Eigen::Vector3d> about;
  about.reserve(points.x.size());
  for (size_t i = 0; i < points.x.size(); ++i) {
    const Eigen::Vector3d p =
        T_vehicle_lidar * Eigen::Vector3d(points.x[i], points.y[i], points.z[i]);
    if (p.head<2>().norm() < kMaxDescribedRange) about.push_back(p);  // NaN is not
  }
  const double ground = ground_height(about);
  PlaceDescriptor out;
  for (const Eigen::Vector3d& p : about) {
    const double height = std::clamp(p.z() - ground, 0.0, kMaxDescribedHeight);
    const double turn = wrap_angle(std::atan2(p.y(), p.x())) / (2 * std::numbers::pi);
    const int ring =
        std::min(static_cast<int>(p.head<2>().norm() / kMaxDescribedRange * kRings), kRings - 1);
    const int sector =
        std::min(static_cast<int>((turn < 0 ? turn + 1 : turn) * kSectors), kSectors - 1);
    float& cell = out.heights(ring, sector);
    cell = std::max(cell, static_cast<float>(std::round(height / kHeightStep) * kHeightStep));
  }
  return out;
}

PlaceKey key_of(const PlaceDescriptor& descriptor) {
  // cos and sin of every sector and harmonic.
  static const auto waves = [] {
    Eigen::Matrix<float, kSectors, 2 * kHarmonics> table;
    for (int sector = 0; sector < kSectors; ++sector) {
      for (int k = 0; k < kHarmonics; ++k) {
        const double angle = 2 * std::numbers::pi * k * sector / kSectors;
        table(sector, 2 * k) = static_cast<float>(std::cos(angle));
        table(sector, 2 * k + 1) = static_cast<float>(std::sin(angle));
      }
    }
    return table;
  }();
  const Eigen::Matrix<float, kRings, 2 * kHarmonics> parts = descriptor.heights * waves;
  PlaceKey key;
  for (int k = 0; k < kHarmonics; ++k) {
    // Not cwiseSqrt(): Eigen's root of floats begins with an approximation that every maker of
    // processors has another of.
    key.segment<kRings>(k * kRings) =
        (parts.col(2 * k).cwiseAbs2() + parts.col(2 * k + 1).cwiseAbs2()).unaryExpr([](float x) {
          return std::sqrt(x);
        });
  }
  const float norm = key.norm();
  return norm > 0 ? PlaceKey(key / norm) : key;
}

PlaceSimilarity compare_places(const PlaceDescriptor& target, const PlaceDescriptor& source) {
  const Eigen::Matrix<float, kRings, kSectors> a = target.heights.array() - target.heights.mean();
  const Eigen::Matrix<float, kRings, kSectors> b = source.heights.array() - source.heights.mean();
  const float norm = a.norm() * b.norm();
  PlaceSimilarity out;
  if (!(norm > 0)) return out;
  // A source that is turned by `shift` sectors shows at azimuth s what the target shows at s +
  // shift.
  out.correlation = -1;
  for (int shift = 0; shift < kSectors; ++shift) {
    const int rest = kSectors - shift;
    const float sum = a.rightCols(rest).cwiseProduct(b.leftCols(rest)).sum() +
                      a.leftCols(shift).cwiseProduct(b.rightCols(shift)).sum();
    const double correlation = static_cast<double>(sum / norm);
    if (correlation <= out.correlation) continue;
    out = {correlation, wrap_angle(2 * std::numbers::pi * shift / kSectors)};
  }
  return out;
}

}  // namespace infuse::places
