#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <deque>
#include <vector>

#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/monitoring/calibration_monitor.hpp"

/// Online test of Levinson and Thrun (Automatic online calibration of cameras and lasers, RSS
/// 2013), as a baseline: depth edges times the inverse distance transform of image edges, summed
/// over nine images; F is the fraction of the 728 poses of a grid around the calibration that fit
/// worse. The distribution of F for a calibrated rig is learned as a Gaussian from the first
/// images; an F three standard deviations below its mean raises an alarm.
namespace infuse::online {

class LevinsonThrun {
 public:
  LevinsonThrun(const CameraIntrinsics& camera, const Eigen::Isometry3d& T)
      : camera_(camera), T_(T) {
    for (int code = 0; code < 729; ++code) {
      geometry::Vector6 xi;
      int rest = code;
      for (int k = 0; k < 6; ++k, rest /= 3) xi(k) = (rest % 3 - 1) * (k < 3 ? 4.4e-3 : 0.05);
      poses_.push_back(geometry::exp(xi));
    }
  }

  void set_calibration(const Eigen::Isometry3d& T) { T_ = T; }

  /// Processes an image; returns true if it raises an alarm.
  bool process(const CameraFrame& grey, const monitoring::SweepView& sweep) {
    points_.select(sweep, camera_, T_, 20'000);
    compute_distance_transform(grey);
    std::array<double, 729> fit{};
    std::vector<uint32_t> edges;
    for (const uint32_t i : points_.near_image()) {
      if (points_.discontinuity()[i] > 0.55F) edges.push_back(i);  // 0.3 m
    }
    for (size_t p = 0; p < poses_.size(); ++p) {
      const Eigen::Isometry3d T = poses_[p] * T_;
      for (const uint32_t i : edges) {
        const auto pixel = camera_.project(
            T * Eigen::Vector3d(sweep.points.x[i], sweep.points.y[i], sweep.points.z[i]));
        if (!pixel) continue;
        const int u = static_cast<int>(pixel->x() / 2);
        const int v = static_cast<int>(pixel->y() / 2);
        if (u < 0 || v < 0 || u >= width_ || v >= height_) continue;
        fit[p] += double{points_.discontinuity()[i]} *
                  double{distance_transform_[static_cast<size_t>(v * width_ + u)]};
      }
    }
    window_.push_back(fit);
    if (window_.size() > 9) window_.pop_front();
    if (window_.size() < 9) return false;
    std::array<double, 729> sum{};
    for (const auto& one : window_) {
      for (size_t p = 0; p < sum.size(); ++p) sum[p] += one[p];
    }
    double worse = 0;
    for (const double value : sum) worse += value < sum[364] ? 1 : 0;  // 364: the unperturbed pose
    const double fraction = worse / 728;
    if (learned_count_ < 40) {
      ++learned_count_;
      mean_ += (fraction - mean_) / learned_count_;
      mean_square_ += (fraction * fraction - mean_square_) / learned_count_;
      return false;
    }
    const double sigma = std::max(0.01, std::sqrt(std::max(0.0, mean_square_ - mean_ * mean_)));
    return fraction < mean_ - 3 * sigma;
  }

 private:
  /// D = α E + (1 − α) max_j E_j γ^distance, α = 1/3, γ = 0.98 per pixel; at half resolution.
  void compute_distance_transform(const CameraFrame& grey) {
    width_ = grey.width / 2;
    height_ = grey.height / 2;
    const auto at = [&](int u, int v) {
      return static_cast<float>(grey.pixels[static_cast<size_t>(2 * v * grey.width + 2 * u)]);
    };
    distance_transform_.assign(static_cast<size_t>(width_ * height_), 0.0F);
    std::vector<float> edge = distance_transform_;
    for (int v = 1; v + 1 < height_; ++v) {
      for (int u = 1; u + 1 < width_; ++u) {
        float max_difference = 0;
        for (int d = 0; d < 9; ++d) {
          max_difference =
              std::max(max_difference, std::abs(at(u, v) - at(u + d % 3 - 1, v + d / 3 - 1)));
        }
        edge[static_cast<size_t>(v * width_ + u)] = max_difference;
      }
    }
    constexpr float kDecay = 0.96F;
    distance_transform_ = edge;
    const auto spread = [&](int u, int v, int du, int dv) {
      if (u + du < 0 || u + du >= width_ || v + dv < 0 || v + dv >= height_) return;
      float& here = distance_transform_[static_cast<size_t>(v * width_ + u)];
      here = std::max(
          here, kDecay * distance_transform_[static_cast<size_t>((v + dv) * width_ + u + du)]);
    };
    for (int v = 0; v < height_; ++v) {
      for (int u = 0; u < width_; ++u) {
        spread(u, v, -1, 0);
        spread(u, v, 0, -1);
      }
    }
    for (int v = height_ - 1; v >= 0; --v) {
      for (int u = width_ - 1; u >= 0; --u) {
        spread(u, v, 1, 0);
        spread(u, v, 0, 1);
      }
    }
    for (size_t i = 0; i < edge.size(); ++i) {
      distance_transform_[i] = edge[i] / 3 + distance_transform_[i] * 2 / 3;
    }
  }

  geometry::CameraModel camera_;
  Eigen::Isometry3d T_;
  monitoring::MonitorPoints points_;
  std::vector<Eigen::Isometry3d> poses_;
  std::vector<float> distance_transform_;
  int width_ = 0, height_ = 0;
  std::deque<std::array<double, 729>> window_;
  int learned_count_ = 0;
  double mean_ = 0, mean_square_ = 0;
};

}  // namespace infuse::online
