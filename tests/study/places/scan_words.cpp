#include "tests/study/places/scan_words.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

#include "fusion/features/plane.hpp"
#include "fusion/registration/visual/sift_returns.hpp"
#include "fusion/registration/visual/visible_returns.hpp"
#include "tests/study/dependence/count_entropy.hpp"

namespace infuse::study {
namespace {

constexpr int kSide = 80, kLayers = 14;  // voxels of a map scan: ±40 m, −2 … 12 m
constexpr float kLowest = -2;
constexpr float kReach = 39;  // m

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
std::vector<int16_t> grey_of_returns(const SeasonScan& scan, const Rig& rig) {
  const Sweep& sweep = scan.scan.sweep;
  std::vector<int16_t> out(sweep.size(), -1);
  for (size_t k = 0; k < rig.cameras.size(); ++k) {
    const features::Plane image = features::grey_plane(scan.scan.images[k]);
    const auto levels = grey_levels(image);
    const registration::VisibleReturns visible({sweep.x, sweep.y, sweep.z}, rig.cameras[k]);
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

registration::SiftReturns sift_of(const SeasonScan& scan, const Rig& rig) {
  const auto images = images_of(scan.scan, rig.cameras);
  auto found =
      registration::find_sift_returns({features::make_sweep_view(scan.scan.sweep), images}, 3);
  if (!found) throw std::runtime_error(found.error().message());
  return *std::move(found);
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

double chao_shen(const std::vector<double>& counts) {
  const Estimate estimate = entropy_chao_shen(counts);
  return estimate.usable() ? estimate.value : 0;
}

}  // namespace

const char* name_of(FeatureSet set) {
  switch (set) {
    case FeatureSet::kReflectivityNormal:
      return "reflectivity, normals";
    case FeatureSet::kReflectivityGreyNormal:
      return "reflectivity and grey, normals";
    case FeatureSet::kSift:
      return "SIFT at returns";
    case FeatureSet::kReflectivityNormalSift:
      return "reflectivity, normals, SIFT";
    case FeatureSet::kAll:
      break;
  }
  return "reflectivity and grey, normals, SIFT";
}

Eigen::MatrixXf sift_descriptors(const SeasonScan& scan, const Rig& rig) {
  return sift_of(scan, rig).descriptors;
}

ScanWords describe_scan(const SeasonScan& scan, const Rig& rig,
                        const registration::Codebook& codebook) {
  const Sweep& sweep = scan.scan.sweep;
  const Eigen::Isometry3f T = rig.lidars.front().T_vehicle_lidar.cast<float>();
  const auto greys = grey_of_returns(scan, rig);
  std::map<std::array<int, 3>, VoxelSums> cells;  // in order, for the same result everywhere
  for (size_t i = 0; i < sweep.size(); ++i) {
    const Eigen::Vector3f p = T * Eigen::Vector3f(sweep.x[i], sweep.y[i], sweep.z[i]);
    if (p.head<2>().norm() > kReach || p.z() > kLowest + kLayers || p.z() < kLowest) continue;
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
    voxel.reflectivity = static_cast<int16_t>(std::min(level, 7.0F));
    if (sums.greys > 0) voxel.grey = static_cast<int16_t>(std::lround(sums.grey / sums.greys));
    set_normal(sums, voxel);
  }
  const registration::SiftReturns sift = sift_of(scan, rig);
  const auto words = registration::quantise(codebook, sift.descriptors);
  for (size_t k = 0; k < sift.size(); ++k) {
    const uint32_t i = sift.returns[k];
    const Eigen::Vector3f p = T * Eigen::Vector3f(sweep.x[i], sweep.y[i], sweep.z[i]);
    if (p.head<2>().norm() > kReach) continue;
    out.keypoints.push_back({p, static_cast<uint16_t>(words[k])});
  }
  return out;
}

double word_information(const std::vector<std::pair<int, int>>& pairs) {
  if (pairs.size() < 20) return 0;
  std::map<int, double> of_first, of_second;
  std::map<std::pair<int, int>, double> of_both;
  for (const auto& pair : pairs) {
    of_first[pair.first] += 1;
    of_second[pair.second] += 1;
    of_both[pair] += 1;
  }
  const auto counts = [](const auto& table) {
    std::vector<double> out;
    for (const auto& [word, count] : table) out.push_back(count);
    return out;
  };
  return chao_shen(counts(of_first)) + chao_shen(counts(of_second)) - chao_shen(counts(of_both));
}

MapScan::MapScan(ScanWords words)
    : words_(std::move(words)),
      voxel_at_(static_cast<size_t>(kSide * kSide * kLayers), -1),
      keypoints_at_(voxel_at_.size()) {
  for (size_t i = 0; i < words_.voxels.size(); ++i) {
    const int at = cell(words_.voxels[i].centre);
    if (at >= 0) voxel_at_[static_cast<size_t>(at)] = static_cast<int32_t>(i);
  }
  for (size_t i = 0; i < words_.keypoints.size(); ++i) {
    const int at = cell(words_.keypoints[i].point);
    if (at >= 0) keypoints_at_[static_cast<size_t>(at)].push_back(static_cast<uint32_t>(i));
  }
}

int MapScan::cell(const Eigen::Vector3f& p) const {
  const int column = static_cast<int>(std::floor(p.x())) + kSide / 2;
  const int row = static_cast<int>(std::floor(p.y())) + kSide / 2;
  const int layer = static_cast<int>(std::floor(p.z() - kLowest));
  if (column < 0 || column >= kSide || row < 0 || row >= kSide || layer < 0 || layer >= kLayers)
    return -1;
  return (layer * kSide + row) * kSide + column;
}

SetInformation MapScan::information(const ScanWords& query, double x, double y, double yaw) const {
  const auto c = static_cast<float>(std::cos(yaw)), s = static_cast<float>(std::sin(yaw));
  const auto moved = [&](const Eigen::Vector3f& p) {
    return Eigen::Vector3f(c * p.x() - s * p.y() + static_cast<float>(x),
                           s * p.x() + c * p.y() + static_cast<float>(y), p.z());
  };
  std::vector<std::pair<int, int>> reflectivity, fused, normals, sift;
  size_t with_grey = 0, with_normal = 0;
  for (const ScanWords::Voxel& own : query.voxels) {
    with_grey += own.grey >= 0 ? 1 : 0;
    with_normal += own.tilt >= 0 ? 1 : 0;
    const int at = cell(moved(own.centre));
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
  // A keypoint corresponds to one of its word within a metre or two, else to the nearest, P 5.2.2.
  for (const ScanWords::Keypoint& own : query.keypoints) {
    const Eigen::Vector3f p = moved(own.point);
    float nearest = 2.25F;
    int word = -1;
    bool same = false;
    for (int dz = -1; dz <= 1; ++dz) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const int at = cell(p + Eigen::Vector3f(static_cast<float>(dx), static_cast<float>(dy),
                                                  static_cast<float>(dz)));
          if (at < 0) continue;
          for (const uint32_t i : keypoints_at_[static_cast<size_t>(at)]) {
            const ScanWords::Keypoint& other = words_.keypoints[i];
            const float squared = (other.point - p).squaredNorm();
            if (squared > 2.25F || (same && other.word != own.word)) continue;
            if ((other.word == own.word && !same) || squared < nearest) {
              same = other.word == own.word;
              nearest = squared;
              word = other.word;
            }
          }
        }
      }
    }
    if (word >= 0) sift.emplace_back(word, own.word);
  }
  // A feature without a counterpart states nothing. Without this a few pairs by chance would win:
  // joint entropies of few pairs come out too low.
  const auto per_feature = [](const std::vector<std::pair<int, int>>& pairs, size_t features) {
    if (features == 0) return 0.0;
    return word_information(pairs) * static_cast<double>(pairs.size()) /
           static_cast<double>(features);
  };
  const double r = per_feature(reflectivity, query.voxels.size());
  const double f = per_feature(fused, with_grey);
  const double n = per_feature(normals, with_normal);
  const double w = per_feature(sift, query.keypoints.size());
  return {r + n, f + n, w, r + n + w, f + n + w};
}

}  // namespace infuse::study
