#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "fusion/dependence/least_squares.hpp"
#include "fusion/geometry/camera_model.hpp"
#include "fusion/streetmap/image_features.hpp"
#include "fusion/streetmap/label_window.hpp"
#include "fusion/streetmap/planar_pose.hpp"

namespace infuse::streetmap {

/// Measure that is maximised over the poses, I table 3.3.
enum class ImageMeasure {
  kLsmi,         ///< SMI by LSMI I(2.7–2.8)
  kBlsmi,        ///< SMI by bagged LSMI I(2.9)
  kMi,           ///< mutual information by MLMI, by far the slowest
  kQmi,          ///< quadratic mutual information by LSQMI
  kSce,          ///< negative squared-loss conditional entropy by LSCE
  kCorrelation,  ///< distance correlation with indicators of the labels
  kBoundaries,   ///< no dependence measure: agreement of gradients with the boundary lines of the
                 ///< map, I(3.7)
};

/// Returns "LSMI", "BLSMI" …
const char* name_of(ImageMeasure measure);

/// Settings of `locate_from_image`, I 3.4.2.1.
struct SingleImageOptions {
  ImageMeasure measure = ImageMeasure::kLsmi;
  Labelling labelling = Labelling::kKinds;
  double max_lateral = 2;     ///< m, search range to either side
  double lateral_step = 0.2;  ///< m
  double max_yaw = 0.35;      ///< rad, search range to either side
  double yaw_step = 0.035;    ///< rad
  double min_distance =
      2;  ///< m along the ground from the vehicle origin; nearer pixels are dropped
  double max_distance = 25;  ///< m; farther pixels are dropped
  int max_samples =
      1500;           ///< maximum number of pixels, evenly spread over those that show the ground
  int bag_count = 8;  ///< number of bags of kBlsmi
  dependence::FitOptions fit{
      .centres = 60, .sigmas = {0.7, 1.0, 1.5, 2.2}, .lambdas = {1e-3, 1e-2, 1e-1}};

  /// Returns what is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

/// Lateral offset and heading relative to a prior pose.
struct SingleImagePose {
  double lateral = 0;  ///< m to the left of the prior
  double yaw = 0;      ///< rad counter-clockwise from the prior
  double score = 0;    ///< score of the best pose
  std::vector<double>
      scores;               ///< of all poses, by heading, then by lateral offset from right to left
  const char* reason = "";  ///< static text: why there is no pose; empty if there is one

  bool usable() const { return *reason == '\0'; }
};

/// Estimates lateral position and heading from a single image by grid search, I 3.4.2. Each pixel
/// that can show the ground is assumed to do so and gets the label of the map at that point. A
/// single image seldom determines the longitudinal position, which is taken from the prior.
SingleImagePose locate_from_image(const SegmentMap& map, const ImageFeatures& features,
                                  const geometry::CameraModel& camera,
                                  const Eigen::Isometry3d& T_camera_vehicle,
                                  const PlanarPose& prior, const SingleImageOptions& options = {});

}  // namespace infuse::streetmap
