#pragma once

#include <functional>
#include <span>
#include <vector>

#include "fusion/streetmap/single_image_pose.hpp"

namespace infuse::streetmap {

/// The pixels of a picture that may see the ground.
struct GroundPixels {
  std::vector<float> x, y;       ///< m, vehicle frame
  std::vector<float> gradients;  ///< Sobel magnitude of each
  Eigen::MatrixXd features;  ///< n × 6: blue, green, red, gradient, cosine and sine of twice its
                             ///< orientation; each column of mean 0 and variance 1

  size_t size() const { return x.size(); }
};

/// Lays the pixels on the plane z = 0 of the vehicle's frame.
GroundPixels find_ground_pixels(const ImageFeatures& features, const geometry::CameraModel& camera,
                                const Eigen::Isometry3d& T_camera_vehicle,
                                const SingleImageOptions& options);

/// Scores labels 0 … label_count − 1 of the pixels; larger is better.
using LabelScore = std::function<double(std::span<const int32_t> labels, int label_count)>;

/// The score of a measure, its side of the pixels prepared; `boundary` tells of a label whether it
/// is a boundary line (kBoundaries only). Empty where the pixels do not vary.
LabelScore make_label_score(const GroundPixels& pixels, const SingleImageOptions& options,
                            const std::vector<bool>& boundary);

}  // namespace infuse::streetmap
