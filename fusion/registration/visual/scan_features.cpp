#include "fusion/registration/visual/scan_features.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <unordered_map>

#include "fusion/features/fpfh.hpp"
#include "fusion/features/plane.hpp"
#include "fusion/registration/visual/visible_returns.hpp"
#include "fusion/registration/voxel_downsample.hpp"
#include "fusion/registration/voxel_key.hpp"

namespace infuse::registration {
namespace {

constexpr size_t kShapePoints = 1000;    // keypoints of a scan with FPFH alone, as P 4.4.1
constexpr size_t kTexturePoints = 5000;  // a quarter of P 4.4.1: a sixteenth of the time
constexpr std::array<std::string_view, 4> kNames{"reflectivity-grey", "fpfh", "sift", "fpfh-sift"};

Eigen::Vector3f point(const features::SweepView& sweep, size_t i) {
  return {sweep.points.x[i], sweep.points.y[i], sweep.points.z[i]};
}

/// Unit vector of a histogram.
Eigen::Map<const Eigen::VectorXf> as_vector(const features::Fpfh& histogram) {
  return {histogram.data(), static_cast<Eigen::Index>(histogram.size())};
}

/// Points on a grid with the shape around them.
struct Shapes {
  std::vector<Eigen::Vector3f> points;
  features::FpfhCloud cloud;
};

Shapes compute_shapes(const features::SweepView& sweep) {
  Shapes shapes;
  const PointCloud thin = voxel_downsample(sweep.points, features::kFpfhGrid);
  for (size_t i = 0; i < thin.size(); ++i)
    shapes.points.emplace_back(thin.x[i], thin.y[i], thin.z[i]);
  shapes.cloud = features::compute_fpfh(shapes.points);
  return shapes;
}

uint64_t key_of(const Eigen::Vector3f& p) {
  const auto cell = [](float c) { return floor_to_int(c / features::kFpfhGrid); };
  return voxel_key(cell(p.x()), cell(p.y()), cell(p.z()));
}

/// Entropy of a histogram: low on planes, where nearly all pairs of points fall into one bin.
float entropy(const features::Fpfh& histogram) {
  float h = 0;
  for (const float p : histogram) {
    if (p > 0) h -= p * std::log(p / 300);
  }
  return h;
}

ScanFeatures shape_features(const features::SweepView& sweep) {
  const Shapes shapes = compute_shapes(sweep);
  std::vector<std::pair<float, size_t>> order;
  for (size_t i = 0; i < shapes.points.size(); ++i) {
    if (shapes.cloud.has_feature[i]) order.emplace_back(-entropy(shapes.cloud.features[i]), i);
  }
  std::sort(order.begin(), order.end());
  order.resize(std::min(order.size(), kShapePoints));
  ScanFeatures found;
  const auto count = static_cast<Eigen::Index>(order.size());
  found.points.resize(3, count);
  found.vectors.resize(3 * features::kFpfhBins, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const size_t i = order[static_cast<size_t>(k)].second;
    found.points.col(k) = shapes.points[i];
    found.vectors.col(k) = as_vector(shapes.cloud.features[i]).normalized();
  }
  return found;
}

ScanFeatures texture_features(const CameraLidarScan& scan) {
  std::vector<std::array<float, 2>> all;
  std::vector<Eigen::Vector3f> at;
  for (const auto& [frame, camera] : scan.images) {
    const VisibleReturns visible(scan.sweep.points, camera);
    const features::Plane grey = features::grey_plane(frame);
    for (int row = 0; row < grey.height; ++row) {
      for (int column = 0; column < grey.width; ++column) {
        const int32_t i = visible.at(column, row);
        if (i < 0) continue;
        const auto r = static_cast<size_t>(i);
        all.push_back({scan.sweep.reflectivity[r], grey.row(row)[column] / 255});
        at.push_back(point(scan.sweep, r));
      }
    }
  }
  const size_t count = std::min(all.size(), kTexturePoints);
  ScanFeatures found;
  found.points.resize(3, static_cast<Eigen::Index>(count));
  found.vectors.resize(2, static_cast<Eigen::Index>(count));
  for (size_t k = 0; k < count; ++k) {
    const size_t i = k * all.size() / count;
    found.points.col(static_cast<Eigen::Index>(k)) = at[i];
    found.vectors.col(static_cast<Eigen::Index>(k)) << all[i][0], all[i][1];
  }
  return found;
}

Result<ScanFeatures> image_features(const CameraLidarScan& scan, bool with_shape) {
  auto sift = find_sift_returns(scan);
  if (!sift) return tl::unexpected(sift.error());
  Shapes shapes;
  std::unordered_map<uint64_t, size_t> shape_at;  // by voxel
  if (with_shape) {
    shapes = compute_shapes(scan.sweep);
    for (size_t i = 0; i < shapes.points.size(); ++i) {
      if (shapes.cloud.has_feature[i]) shape_at.emplace(key_of(shapes.points[i]), i);
    }
  }
  ScanFeatures found;
  const Eigen::Index shape_rows = with_shape ? 3 * features::kFpfhBins : 0;
  const auto count = static_cast<Eigen::Index>(sift->size());
  found.points.resize(3, count);
  found.vectors.resize(shape_rows + 128, count);
  Eigen::Index kept = 0;
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Vector3f p = point(scan.sweep, sift->returns[static_cast<size_t>(k)]);
    if (with_shape) {
      const auto shape = shape_at.find(key_of(p));
      if (shape == shape_at.end()) continue;
      found.vectors.col(kept).head(shape_rows) =
          as_vector(shapes.cloud.features[shape->second]).normalized();
    }
    found.vectors.col(kept).tail(128) = sift->descriptors.col(k);
    found.points.col(kept++) = p;
  }
  found.points.conservativeResize(3, kept);
  found.vectors.conservativeResize(Eigen::NoChange, kept);
  return found;
}

}  // namespace

std::string_view name(ScanFeature feature) { return kNames[static_cast<size_t>(feature)]; }

std::optional<ScanFeature> find_scan_feature(std::string_view name) {
  const auto at = std::find(kNames.begin(), kNames.end(), name);
  if (at == kNames.end()) return std::nullopt;
  return static_cast<ScanFeature>(at - kNames.begin());
}

Result<ScanFeatures> compute_scan_features(const CameraLidarScan& scan, ScanFeature feature) {
  switch (feature) {
    case ScanFeature::kReflectivityGrey:
      return texture_features(scan);
    case ScanFeature::kFpfh:
      return shape_features(scan.sweep);
    case ScanFeature::kSift:
      return image_features(scan, false);
    case ScanFeature::kFpfhSift:
      return image_features(scan, true);
  }
  return fail("unknown feature");
}

}  // namespace infuse::registration
