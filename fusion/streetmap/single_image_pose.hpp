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

/// What is maximised over the poses, I table 3.3.
enum class ImageMeasure {
  kLsmi,         ///< SMI by LSMI I(2.7–2.8)
  kBlsmi,        ///< SMI by bagged LSMI I(2.9)
  kMi,           ///< mutual information by MLMI, by far the slowest
  kQmi,          ///< quadratic mutual information by LSQMI
  kSce,          ///< squared-loss conditional entropy by LSCE, its negative
  kCorrelation,  ///< distance correlation with indicators of the labels
  kBoundaries,   ///< no dependence: do gradients lie on the map's boundary lines, I(3.7)
};

/// "LSMI", "BLSMI" …
const char* name(ImageMeasure measure);

/// How one picture is laid on the map, I 3.4.2.1.
struct SingleImageOptions {
  ImageMeasure measure = ImageMeasure::kLsmi;
  Labelling labelling = Labelling::kKinds;
  double max_lateral = 2;     ///< m to either side that are searched
  double lateral_step = 0.2;  ///< m
  double max_yaw = 0.35;      ///< rad to either side that are searched
  double yaw_step = 0.035;    ///< rad
  double min_distance = 2;    ///< m along the ground from the vehicle's origin; nearer is left out
  double max_distance = 25;   ///< m; farther is left out
  int max_samples = 1500;     ///< pixels, evenly over those that see the ground
  int bag_count = 8;          ///< of kBlsmi
  dependence::FitOptions fit{
      .centres = 60, .sigmas = {0.7, 1.0, 1.5, 2.2}, .lambdas = {1e-3, 1e-2, 1e-1}};

  /// What is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

/// Where the vehicle is beside and turned against a prior pose.
struct SingleImagePose {
  double lateral = 0;          ///< m to the left of the prior
  double yaw = 0;              ///< rad counter-clockwise from the prior
  double score = 0;            ///< of the best pose
  std::vector<double> scores;  ///< of all, by turn, then across, from right to left
  const char* reason = "";     ///< static text: why there is no pose; empty where there is

  bool usable() const { return *reason == '\0'; }
};

/// Lateral position and heading from a single picture by grid search, I 3.4.2: each pixel that can
/// see the ground is taken as if it did, and given the label that the map has there. How far along
/// the road the vehicle is a picture seldom tells; that is the prior's.
SingleImagePose locate_from_image(const SegmentMap& map, const ImageFeatures& features,
                                  const geometry::CameraModel& camera,
                                  const Eigen::Isometry3d& T_camera_vehicle,
                                  const PlanarPose& prior, const SingleImageOptions& options = {});

}  // namespace infuse::streetmap
