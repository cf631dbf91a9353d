#pragma once

#include <functional>
#include <span>
#include <vector>

#include "tests/study/streetmap/single_image_pose.hpp"

namespace infuse::streetmap {

/// Pixels of an image that may show the ground.
struct GroundPixels {
  std::vector<float> x, y;       ///< m, vehicle frame
  std::vector<float> gradients;  ///< Sobel magnitude by pixel
  Eigen::MatrixXd features;  ///< n × 6: blue, green, red, gradient, cosine and sine of twice the
                             ///< orientation; each column has mean 0 and variance 1

  size_t size() const { return x.size(); }
};

/// Projects the pixels onto the plane z = 0 of the vehicle frame.
GroundPixels find_ground_pixels(const ImageFeatures& features, const geometry::CameraModel& camera,
                                const Eigen::Isometry3d& T_camera_vehicle,
                                const SingleImageOptions& options);

/// Scores labels 0 … label_count − 1 of the pixels; larger is better.
using LabelScore = std::function<double(std::span<const int32_t> labels, int label_count)>;

/// Returns the score function of a measure, prepared for the pixels. `boundary[l]` is true if label
/// l is a boundary line (used by kBoundaries only). Empty if the pixels do not vary.
LabelScore make_label_score(const GroundPixels& pixels, const SingleImageOptions& options,
                            const std::vector<bool>& boundary);

}  // namespace infuse::streetmap
