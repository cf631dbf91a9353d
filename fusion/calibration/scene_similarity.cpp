#include "fusion/calibration/scene_similarity.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "drivers/measurement/angles.hpp"
#include "fusion/geometry/plane_length.hpp"

namespace infuse::calibration {
namespace {

constexpr int kSignatureWidth = 160;    // samples across an image
constexpr int kImageSurroundings = 5;   // samples on each side
constexpr double kCellDegrees = 0.5;    // of azimuth; twice that of elevation
constexpr int kAzimuthCells = 720;      // 360 degrees
constexpr int kElevationCells = 60;     // from -30 to 30 degrees
constexpr int kReturnSurroundings = 6;  // cells of azimuth on each side
constexpr double kMinRange = 0.01;      // m
constexpr double kShareByChance = 0.2;  // correlation of different places

/// Values less the mean of those around them, as a vector of length one (or zero).
Eigen::VectorXf fine_structure(const Eigen::ArrayXXf& rows, int across, int along) {
  const auto height = static_cast<int>(rows.rows()), width = static_cast<int>(rows.cols());
  Eigen::ArrayXXd sums = Eigen::ArrayXXd::Zero(height + 1, width + 1);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      sums(v + 1, u + 1) =
          static_cast<double>(rows(v, u)) + sums(v, u + 1) + sums(v + 1, u) - sums(v, u);
    }
  }
  Eigen::VectorXf fine(height * width);
  for (int v = 0; v < height; ++v) {
    const int top = std::max(v - along, 0), bottom = std::min(v + along + 1, height);
    for (int u = 0; u < width; ++u) {
      const int left = std::max(u - across, 0), right = std::min(u + across + 1, width);
      const double sum =
          sums(bottom, right) - sums(top, right) - sums(bottom, left) + sums(top, left);
      const double mean = sum / ((bottom - top) * (right - left));
      fine(v * width + u) = rows(v, u) - static_cast<float>(mean);
    }
  }
  const float norm = fine.norm();
  if (norm > 0) fine /= norm;
  return fine;
}

/// Fine structure of the first image feature that there is.
Eigen::VectorXf image_signature(const Scene& scene) {
  for (const features::Plane& plane : scene.image) {
    if (plane.values.empty()) continue;
    const int step = std::max(plane.width / kSignatureWidth, 1);
    Eigen::ArrayXXf means = Eigen::ArrayXXf::Zero(plane.height / step, plane.width / step);
    for (int v = 0; v < means.rows() * step; ++v) {
      const float* row = plane.row(v);
      for (int u = 0; u < means.cols() * step; ++u) means(v / step, u / step) += row[u];
    }
    return fine_structure(means, kImageSurroundings, kImageSurroundings);
  }
  return {};
}

/// Fine structure of the returns' inverse ranges, cell by cell of direction. Every return is shared
/// by the four cells around it: a beam that points along a border of cells does not jump.
Eigen::VectorXf return_signature(const Scene& scene) {
  Eigen::ArrayXXf inverse = Eigen::ArrayXXf::Zero(kElevationCells, kAzimuthCells);
  for (size_t i = 0; i < scene.size(); ++i) {
    const double x = static_cast<double>(scene.x[i]), y = static_cast<double>(scene.y[i]);
    const double z = static_cast<double>(scene.z[i]), flat = geometry::plane_length(x, y);
    const double azimuth = (std::atan2(y, x) / kDegree + 180) / kCellDegrees;
    const double elevation =
        (std::atan2(z, flat) / kDegree + kElevationCells * kCellDegrees) / (2 * kCellDegrees);
    const auto row = static_cast<int>(std::floor(elevation));
    const auto column = static_cast<int>(std::floor(azimuth));
    if (row < 0 || row + 1 >= kElevationCells) continue;
    const double nearness = 1 / std::max(geometry::plane_length(flat, z), kMinRange);
    const double up = elevation - row, right = azimuth - column;
    for (const int r : {0, 1}) {
      for (const int c : {0, 1}) {
        const double share = (r == 1 ? up : 1 - up) * (c == 1 ? right : 1 - right);
        inverse(row + r, (column + c) % kAzimuthCells) += static_cast<float>(share * nearness);
      }
    }
  }
  return fine_structure(inverse, kReturnSurroundings, 0);
}

double correlation(const Eigen::VectorXf& a, const Eigen::VectorXf& b) {
  return a.size() == b.size() && a.size() > 0 ? std::max(0.0, static_cast<double>(a.dot(b))) : 0;
}

}  // namespace

SceneSignature make_signature(const Scene& scene) {
  return {image_signature(scene), return_signature(scene)};
}

Eigen::MatrixXd scene_similarity(std::span<const Scene> scenes) {
  std::vector<std::shared_ptr<const SceneSignature>> all;
  for (const Scene& scene : scenes) {
    all.push_back(scene.signature != nullptr
                      ? scene.signature
                      : std::make_shared<const SceneSignature>(make_signature(scene)));
  }
  const auto n = static_cast<Eigen::Index>(scenes.size());
  Eigen::MatrixXd similarity = Eigen::MatrixXd::Identity(n, n);
  for (size_t a = 0; a < scenes.size(); ++a) {
    for (size_t b = 0; b < a; ++b) {
      if (scenes[a].camera != scenes[b].camera) continue;
      const double alike = std::sqrt(correlation(all[a]->image, all[b]->image) *
                                     correlation(all[a]->returns, all[b]->returns));
      const auto row = static_cast<Eigen::Index>(a), column = static_cast<Eigen::Index>(b);
      similarity(row, column) = similarity(column, row) =
          std::clamp((alike - kShareByChance) / (1 - kShareByChance), 0.0, 1.0);
    }
  }
  return similarity;
}

double effective_scenes(const Eigen::MatrixXd& similarity) {
  const auto n = static_cast<double>(similarity.rows());
  return n > 0 ? n * n / similarity.sum() : 0;
}

}  // namespace infuse::calibration
