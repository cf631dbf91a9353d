#include "fusion/places/visual/scan_words.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "fusion/dependence/count_entropy.hpp"
#include "fusion/features/plane.hpp"
#include "fusion/registration/visual/visible_returns.hpp"

namespace infuse::places {
namespace {

constexpr float kLowest = -2;
constexpr float kReach = kPlaceSide / 2 - 1;  // m

/// Rank of every grey value within an image, 0 … 7.
std::array<int16_t, 256> grey_levels(const features::Plane& image) {
  std::array<double, 256> counts{};
  for (int row = 0; row < image.height; ++row) {
    for (const float* p = image.row(row); p != image.row(row) + image.width; ++p)
      counts[static_cast<size_t>(std::clamp(*p, 0.0F, 255.0F))] += 1;
  }
  std::array<int16_t, 256> levels{};
  double below = 0;
  const double all = static_cast<double>(image.width) * image.height;
  for (size_t value = 0; value < 256; ++value) {
    levels[value] =
        static_cast<int16_t>(std::min(7.0, std::floor(8 * (below + counts[value] / 2) / all)));
    below += counts[value];
  }
  return levels;
}

/// Grey level of each return, −1 where no image shows it.
std::vector<int16_t> grey_of_returns(const registration::CameraLidarScan& scan) {
  std::vector<int16_t> out(scan.sweep.size(), -1);
  for (const registration::ScanImage& view : scan.images) {
    const features::Plane image = features::grey_plane(view.frame);
    const auto levels = grey_levels(image);
    const registration::VisibleReturns visible(scan.sweep.points, view.camera);
    for (int row = 0; row < image.height; ++row) {
      for (int column = 0; column < image.width; ++column) {
        const int32_t i = visible.at(column, row);
        if (i < 0) continue;
        out[static_cast<size_t>(i)] =
            levels[static_cast<size_t>(std::clamp(image.row(row)[column], 0.0F, 255.0F))];
      }
    }
  }
  return out;
}

struct VoxelSums {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  Eigen::Matrix3f squares = Eigen::Matrix3f::Zero();
  float reflectivity = 0, count = 0, grey = 0, greys = 0;
};

void set_normal(const VoxelSums& sums, ScanWords::Voxel& voxel) {
  if (sums.count < 6) return;
  const Eigen::Vector3f mean = sums.sum / sums.count;
  const Eigen::Matrix3f spread = sums.squares / sums.count - mean * mean.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver(spread);
  const Eigen::Vector3f values = solver.eigenvalues();
  if (!(values[0] < 0.2F * values[1]) || values[1] < 1e-4F) return;  // not a plane
  const Eigen::Vector3f normal = solver.eigenvectors().col(0);
  const float up = std::abs(normal.z());
  voxel.tilt = up > 0.85F ? 0 : up > 0.4F ? 1 : 2;
  voxel.azimuth = std::atan2(normal.y(), normal.x());
}

int normal_word(const ScanWords::Voxel& voxel, double yaw) {
  if (voxel.tilt <= 0) return voxel.tilt;  // unknown or upright
  constexpr int kBins = 6;
  const double turns = (static_cast<double>(voxel.azimuth) + yaw) / std::numbers::pi;
  const int bin = static_cast<int>((turns - std::floor(turns)) * kBins) % kBins;
  return 1 + (voxel.tilt - 1) * kBins + bin;
}

}  // namespace

ScanWords describe_scan(const registration::CameraLidarScan& scan,
                        const Eigen::Isometry3d& T_vehicle_lidar) {
  const features::SweepView& sweep = scan.sweep;
  const Eigen::Isometry3f T = T_vehicle_lidar.cast<float>();
  const auto greys = grey_of_returns(scan);
  std::map<std::array<int, 3>, VoxelSums> cells;  // in order, for the same result everywhere
  for (size_t i = 0; i < sweep.size(); ++i) {
    const Eigen::Vector3f p =
        T * Eigen::Vector3f(sweep.points.x[i], sweep.points.y[i], sweep.points.z[i]);
    if (!(p.head<2>().norm() <= kReach && p.z() >= kLowest && p.z() < kLowest + kPlaceLayers))
      continue;
    VoxelSums& v = cells[{static_cast<int>(std::floor(p.x())), static_cast<int>(std::floor(p.y())),
                          static_cast<int>(std::floor(p.z()))}];
    v.sum += p;
    v.squares += p * p.transpose();
    v.reflectivity += sweep.reflectivity[i];
    v.count += 1;
    if (greys[i] >= 0) {
      v.grey += greys[i];
      v.greys += 1;
    }
  }
  ScanWords out;
  for (const auto& [key, sums] : cells) {
    ScanWords::Voxel& voxel = out.voxels.emplace_back();
    voxel.centre = sums.sum / sums.count;
    // A white diffuse surface has 100 / 255; beyond it are retro-reflectors.
    const float level = std::floor(sums.reflectivity / sums.count * 255 / 14);
    voxel.reflectivity = static_cast<int16_t>(std::clamp(level, 0.0F, 7.0F));
    if (sums.greys > 0) voxel.grey = static_cast<int16_t>(std::lround(sums.grey / sums.greys));
    set_normal(sums, voxel);
  }
  return out;
}

double word_information(const std::vector<std::pair<int, int>>& pairs, size_t features) {
  if (pairs.size() < 20) return 0;
  int last = 0;
  for (const auto& [a, b] : pairs) last = std::max({last, a, b});
  const auto words = static_cast<size_t>(last) + 1;
  std::vector<double> of_first(words), of_second(words), of_both(words * words);
  for (const auto& pair : pairs) {
    const auto first = static_cast<size_t>(pair.first), second = static_cast<size_t>(pair.second);
    of_first[first] += 1;
    of_second[second] += 1;
    of_both[first * words + second] += 1;
  }
  const double information = dependence::entropy_chao_shen(of_first).value +
                             dependence::entropy_chao_shen(of_second).value -
                             dependence::entropy_chao_shen(of_both).value;
  return information * static_cast<double>(pairs.size()) / static_cast<double>(features);
}

int voxel_index(const Eigen::Vector3f& point) {
  const int column = static_cast<int>(std::floor(point.x())) + kPlaceSide / 2;
  const int row = static_cast<int>(std::floor(point.y())) + kPlaceSide / 2;
  const int layer = static_cast<int>(std::floor(point.z() - kLowest));
  if (column < 0 || column >= kPlaceSide || row < 0 || row >= kPlaceSide || layer < 0 ||
      layer >= kPlaceLayers)
    return -1;
  return (layer * kPlaceSide + row) * kPlaceSide + column;
}

MapScan::MapScan(ScanWords words) : words_(std::move(words)), voxel_at_(kPlaceVoxels, -1) {
  for (size_t i = 0; i < words_.voxels.size(); ++i) {
    const int at = voxel_index(words_.voxels[i].centre);
    if (at >= 0) voxel_at_[static_cast<size_t>(at)] = static_cast<int32_t>(i);
  }
}

TotalInformation MapScan::information(const ScanWords& query, double x, double y,
                                      double yaw) const {
  const auto c = static_cast<float>(std::cos(yaw)), s = static_cast<float>(std::sin(yaw));
  const auto moved = [&](const Eigen::Vector3f& p) {
    return Eigen::Vector3f(c * p.x() - s * p.y() + static_cast<float>(x),
                           s * p.x() + c * p.y() + static_cast<float>(y), p.z());
  };
  std::vector<std::pair<int, int>> reflectivity, fused, normals;
  size_t with_grey = 0, with_normal = 0;
  for (const ScanWords::Voxel& own : query.voxels) {
    with_grey += own.grey >= 0 ? 1 : 0;
    with_normal += own.tilt >= 0 ? 1 : 0;
    const int at = voxel_index(moved(own.centre));
    if (at < 0 || voxel_at_[static_cast<size_t>(at)] < 0) continue;
    const ScanWords::Voxel& there =
        words_.voxels[static_cast<size_t>(voxel_at_[static_cast<size_t>(at)])];
    reflectivity.emplace_back(there.reflectivity, own.reflectivity);
    if (own.grey >= 0 && there.grey >= 0) {
      fused.emplace_back(8 * there.reflectivity + there.grey, 8 * own.reflectivity + own.grey);
    }
    const int a = normal_word(there, 0), b = normal_word(own, yaw);
    if (a >= 0 && b >= 0) normals.emplace_back(a, b);
  }
  return {.reflectivity = word_information(reflectivity, query.voxels.size()),
          .reflectivity_grey = word_information(fused, with_grey),
          .normals = word_information(normals, with_normal)};
}

InformationAlignment search_by_information(const MapScan& place, const ScanWords& query, double yaw,
                                           bool grey) {
  InformationAlignment best;
  double most = -1;
  for (const double turned : {0.0, std::numbers::pi}) {
    for (const double x : {-4.0, -2.0, 0.0, 2.0, 4.0}) {
      for (const double y : {-6.0, -4.0, -2.0, 0.0, 2.0, 4.0, 6.0}) {
        const TotalInformation information = place.information(query, x, y, yaw + turned);
        if (information.total(grey) <= most) continue;
        most = information.total(grey);
        best = {x, y, yaw + turned, information};
      }
    }
  }
  return best;
}

InformationAlignment refine_by_information(const MapScan& place, const ScanWords& query,
                                           InformationAlignment guess, bool grey) {
  constexpr double kFarthest = 8;  // m: farther away another place is nearer
  InformationAlignment best = guess;
  for (const double scale : {0.5, 0.25}) {
    for (bool improved = true; improved;) {
      improved = false;
      const double step = 2 * scale, turn = 0.07 * scale;
      const std::array<std::array<double, 3>, 6> moves{
          {{step, 0, 0}, {-step, 0, 0}, {0, step, 0}, {0, -step, 0}, {0, 0, turn}, {0, 0, -turn}}};
      for (const auto& [dx, dy, turned] : moves) {
        const double x = best.x + dx, y = best.y + dy, yaw = best.yaw + turned;
        if (std::hypot(x, y) > kFarthest) continue;
        const TotalInformation other = place.information(query, x, y, yaw);
        if (other.total(grey) <= best.information.total(grey)) continue;
        best = {x, y, yaw, other};
        improved = true;
      }
    }
  }
  return best;
}

}  // namespace infuse::places
