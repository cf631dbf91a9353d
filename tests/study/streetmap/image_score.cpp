#include "tests/study/streetmap/image_score.hpp"

#include <cmath>
#include <numeric>

#include "fusion/dependence/prepared_dependence.hpp"
#include "tests/study/dependence/distance_correlation.hpp"
#include "tests/study/dependence/paired_density_ratio.hpp"

namespace infuse::streetmap {
namespace {

using dependence::FitMeasure;
using dependence::PreparedDependence;
using Eigen::Index;

void standardise(Eigen::MatrixXd& features) {
  for (Index c = 0; c < features.cols(); ++c) {
    auto column = features.col(c);
    column.array() -= column.mean();
    const double sigma = std::sqrt(column.squaredNorm() / static_cast<double>(column.size()));
    if (sigma > 1e-6) column /= sigma;
  }
}

/// A least-squares measure over all pixels. Hyper-parameters are chosen at the first evaluation and
/// kept, because scores with different hyper-parameters are not comparable.
LabelScore make_least_squares_score(FitMeasure measure, const Eigen::MatrixXd& features,
                                    const dependence::FitOptions& fit) {
  const auto prepared = std::make_shared<PreparedDependence>(measure, features, fit);
  if (*prepared->reason() != '\0') return {};
  const auto kept = std::make_shared<std::optional<dependence::HyperParameters>>();
  const double sign = measure == FitMeasure::kSce ? -1 : 1;
  return [=](std::span<const int32_t> labels, int label_count) {
    const auto answer = prepared->evaluate(labels, label_count, *kept);
    if (answer.usable() && !*kept) *kept = answer.hyper_parameters;
    return answer.usable() ? sign * answer.value : 0;
  };
}

/// Mean of LSMI over bags, I(2.9). Bag b holds every k-th pixel from pixel b on.
LabelScore make_bagged_score(const Eigen::MatrixXd& features, const SingleImageOptions& options) {
  const Index bags = options.bag_count, size = features.rows() / bags;
  std::vector<LabelScore> parts;
  for (Index b = 0; b < bags; ++b) {
    Eigen::MatrixXd part(size, features.cols());
    for (Index i = 0; i < size; ++i) part.row(i) = features.row(i * bags + b);
    parts.push_back(make_least_squares_score(FitMeasure::kSmi, part, options.fit));
    if (!parts.back()) return {};
  }
  return [=](std::span<const int32_t> labels, int label_count) {
    std::vector<int32_t> part(static_cast<size_t>(size));
    double sum = 0;
    for (size_t b = 0; b < parts.size(); ++b) {
      for (size_t i = 0; i < part.size(); ++i) part[i] = labels[i * parts.size() + b];
      sum += parts[b](part, label_count);
    }
    return sum / static_cast<double>(parts.size());
  };
}

LabelScore make_mlmi_score(const Eigen::MatrixXd& features, const dependence::FitOptions& fit) {
  const auto options = std::make_shared<dependence::FitOptions>(fit);
  return [=](std::span<const int32_t> labels, int label_count) {
    const auto answer = study::mlmi(features, labels, label_count, *options);
    if (answer.usable()) options->sigmas = {answer.hyper_parameters.sigma};
    return answer.usable() ? answer.value : 0;
  };
}

LabelScore make_correlation_score(const Eigen::MatrixXd& features) {
  return [=](std::span<const int32_t> labels, int label_count) {
    Eigen::MatrixXd indicators = Eigen::MatrixXd::Zero(features.rows(), label_count);
    for (size_t i = 0; i < labels.size(); ++i) indicators(static_cast<Index>(i), labels[i]) = 1;
    const auto answer = study::distance_correlation(features, indicators);
    return answer.usable() ? answer.value : 0;
  };
}

// I(3.7) with the gradient as boundary strength: an image has no range discontinuity.
LabelScore make_boundary_score(const GroundPixels& pixels, const std::vector<bool>& boundary) {
  double squares = 0;
  for (const float gradient : pixels.gradients) squares += gradient * gradient;
  if (!(squares > 0)) return {};
  return [=, gradients = pixels.gradients](std::span<const int32_t> labels, int) {
    double sum = 0, count = 0;
    for (size_t i = 0; i < labels.size(); ++i) {
      if (!boundary[static_cast<size_t>(labels[i])]) continue;
      sum += gradients[i];
      ++count;
    }
    return count > 0 ? sum / std::sqrt(squares * count) : 0;
  };
}

}  // namespace

GroundPixels find_ground_pixels(const ImageFeatures& features, const geometry::CameraModel& camera,
                                const Eigen::Isometry3d& T_camera_vehicle,
                                const SingleImageOptions& options) {
  const Eigen::Isometry3d T_vehicle_camera = T_camera_vehicle.inverse();
  const Eigen::Vector3d camera_position = T_vehicle_camera.translation();
  const double fx = static_cast<double>(camera.intrinsics().width) / features.width;
  const double fy = static_cast<double>(camera.intrinsics().height) / features.height;
  GroundPixels all;
  std::vector<const std::array<float, 5>*> seen;
  for (int v = 0; v < features.height; ++v) {
    for (int u = 0; u < features.width; ++u) {
      const auto ray = camera.unproject({(u + 0.5) * fx - 0.5, (v + 0.5) * fy - 0.5});
      if (!ray) continue;
      const Eigen::Vector3d d = T_vehicle_camera.linear() * *ray;
      if (!(d.z() < -1e-3)) continue;
      const Eigen::Vector3d p = camera_position - camera_position.z() / d.z() * d;
      const double distance = p.head<2>().norm();
      if (!(distance > options.min_distance && distance < options.max_distance)) continue;
      all.x.push_back(static_cast<float>(p.x()));
      all.y.push_back(static_cast<float>(p.y()));
      seen.push_back(&features.at(u, v));
    }
  }
  // Every k-th pixel in row order: evenly spread over the image.
  const size_t n = std::min(seen.size(), static_cast<size_t>(options.max_samples));
  GroundPixels pixels;
  pixels.features.resize(static_cast<Index>(n), 6);
  for (size_t i = 0; i < n; ++i) {
    const size_t at = i * seen.size() / n;
    const auto& pixel = *seen[at];
    pixels.x.push_back(all.x[at]);
    pixels.y.push_back(all.y[at]);
    pixels.gradients.push_back(pixel[3]);
    auto row = pixels.features.row(static_cast<Index>(i));
    for (int c = 0; c < 4; ++c) row[c] = pixel[static_cast<size_t>(c)];
    row[4] = pixel[3] * std::cos(2 * pixel[4]);
    row[5] = pixel[3] * std::sin(2 * pixel[4]);
  }
  if (n > 0) standardise(pixels.features);
  return pixels;
}

LabelScore make_label_score(const GroundPixels& pixels, const SingleImageOptions& options,
                            const std::vector<bool>& boundary) {
  switch (options.measure) {
    case ImageMeasure::kLsmi:
      return make_least_squares_score(FitMeasure::kSmi, pixels.features, options.fit);
    case ImageMeasure::kBlsmi:
      return make_bagged_score(pixels.features, options);
    case ImageMeasure::kMi:
      return make_mlmi_score(pixels.features, options.fit);
    case ImageMeasure::kQmi:
      return make_least_squares_score(FitMeasure::kQmi, pixels.features, options.fit);
    case ImageMeasure::kSce:
      return make_least_squares_score(FitMeasure::kSce, pixels.features, options.fit);
    case ImageMeasure::kCorrelation:
      return make_correlation_score(pixels.features);
    case ImageMeasure::kBoundaries:
      return make_boundary_score(pixels, boundary);
  }
  return {};
}

}  // namespace infuse::streetmap
