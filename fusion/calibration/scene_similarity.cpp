#include "fusion/calibration/scene_similarity.hpp"

#include <algorithm>
#include <memory>
#include <vector>

namespace infuse::calibration {
namespace {

constexpr int kSignatureWidth = 160;    // samples across an image (decision 6)
constexpr int kSurroundings = 5;        // samples on each side
constexpr double kShareByChance = 0.2;  // correlation of different places (decision 6)

/// Values less the mean of those around them, as a vector of length one (or zero).
Eigen::VectorXf fine_structure(const Eigen::ArrayXXf& rows) {
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
    const int top = std::max(v - kSurroundings, 0),
              bottom = std::min(v + kSurroundings + 1, height);
    for (int u = 0; u < width; ++u) {
      const int left = std::max(u - kSurroundings, 0),
                right = std::min(u + kSurroundings + 1, width);
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

double correlation(const Eigen::VectorXf& a, const Eigen::VectorXf& b) {
  return a.size() == b.size() && a.size() > 0 ? std::max(0.0, static_cast<double>(a.dot(b))) : 0;
}

}  // namespace

Eigen::VectorXf make_signature(const Scene& scene) {
  for (const features::Plane& plane : scene.image) {
    if (plane.values.empty()) continue;
    const int step = std::max(plane.width / kSignatureWidth, 1);
    Eigen::ArrayXXf means = Eigen::ArrayXXf::Zero(plane.height / step, plane.width / step);
    for (int v = 0; v < means.rows() * step; ++v) {
      const float* row = plane.row(v);
      for (int u = 0; u < means.cols() * step; ++u) means(v / step, u / step) += row[u];
    }
    return fine_structure(means);
  }
  return {};
}

Eigen::MatrixXd scene_similarity(std::span<const Scene> scenes) {
  std::vector<std::shared_ptr<const Eigen::VectorXf>> all;
  for (const Scene& scene : scenes) {
    all.push_back(scene.signature != nullptr
                      ? scene.signature
                      : std::make_shared<const Eigen::VectorXf>(make_signature(scene)));
  }
  const auto n = static_cast<Eigen::Index>(scenes.size());
  Eigen::MatrixXd similarity = Eigen::MatrixXd::Identity(n, n);
  for (size_t a = 0; a < scenes.size(); ++a) {
    for (size_t b = 0; b < a; ++b) {
      if (scenes[a].camera != scenes[b].camera) continue;
      const double alike = correlation(*all[a], *all[b]);
      const auto row = static_cast<Eigen::Index>(a), column = static_cast<Eigen::Index>(b);
      similarity(row, column) = similarity(column, row) =
          std::clamp((alike - kShareByChance) / (1 - kShareByChance), 0.0, 1.0);
    }
  }
  return similarity;
}

Eigen::VectorXd scene_weights(const Eigen::MatrixXd& similarity) {
  if (similarity.size() == 0) return {};
  const Eigen::VectorXd share = similarity.rowwise().sum().cwiseInverse().cwiseSqrt();
  return share / share.maxCoeff();
}

double effective_scenes(const Eigen::MatrixXd& similarity, const Eigen::VectorXd& weights) {
  if (similarity.size() == 0) return 0;
  return weights.sum() * weights.sum() / weights.dot(similarity * weights);
}

double design_effect(const Eigen::MatrixXd& similarity, const Eigen::VectorXd& weights) {
  if (similarity.size() == 0) return 1;
  return weights.dot(similarity * weights) / weights.squaredNorm();
}

}  // namespace infuse::calibration
