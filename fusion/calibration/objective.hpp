#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "fusion/calibration/dependence_term.hpp"
#include "fusion/calibration/image_blur.hpp"
#include "fusion/calibration/scene.hpp"
#include "fusion/calibration/scene_images.hpp"
#include "fusion/calibration/visible_points.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::calibration {

/// Image features of all scenes, blurred alike and thinned as the blur allows: computed once per
/// level of a coarse-to-fine search, shared by all poses.
class BlurredImages {
 public:
  /// Scenes whose images are released (`compact_scene`) must have been prepared for the blur.
  BlurredImages(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                std::span<const TermOptions> terms, const ImageBlur& blur);

  /// Images that are blurred already, one entry per scene.
  explicit BlurredImages(std::vector<SceneImages::Level> images) : images_(std::move(images)) {}

  const CompactPlane& plane(size_t scene, ImageFeature feature) const {
    return (*images_[scene])[index(feature)];
  }

  /// Returns the same images assigned to other scenes: scene s has that of `source_scenes[s]`.
  BlurredImages permuted(std::span<const size_t> source_scenes) const;

 private:
  std::vector<SceneImages::Level> images_;
};

/// True for the image features that a term compares.
PerImageFeature<bool> compared_image_features(std::span<const TermOptions> terms);

/// Objective at one pose.
struct Evaluation {
  dependence::Estimate estimate;
  /// ∂value/∂ξ, ξ a left perturbation of T_refcam_lidar (rx, ry, rz, tx, ty, tz; rad, m).
  geometry::Vector6 gradient = geometry::Vector6::Zero();
};

/// Gradient of a scene's part of the objective by the pose (six entries, as Evaluation::gradient)
/// and by its camera's model: by the logarithm of the focal lengths, the principal point (u, v, px)
/// and the first radial distortion coefficient.
using SceneGradient = Eigen::Matrix<double, 10, 1>;
/// Information about the same ten parameters.
using SceneInformation = Eigen::Matrix<double, 10, 10>;

/// Number of bands of depth with a displacement each: below 8 m, to 16 m, to 32 m, and beyond.
/// Octaves, since a shift of the camera moves pixels by the inverse of the depth
/// (decision 18).
inline constexpr size_t kDepthBands = 4;

/// Information between the ten parameters and displacements of the pixels of all scenes alike,
/// 1/px: for each camera and band of depths (`kDepthBands`) across and down, one column each.
/// Camera after camera, the nearest band first. A displacement δ moves the maximum by −I⁻¹ b δ, I
/// the information of all scenes and b its column.
using BiasInformation = Eigen::Matrix<double, 10, Eigen::Dynamic>;

/// Information of the points at a pose.
struct PointInformation {
  /// Fisher information P(3.19) of each scene, Σᵢ sᵢ sᵢᵀ over its points: sᵢ is the derivative by
  /// the pose and by the camera's model of point i's part of each term times the term's samples,
  /// for mutual information that of log p(x, y) / (p(x) p(y)).
  std::vector<SceneInformation> scenes;
  BiasInformation bias;
};

/// Returns the information of all scenes together.
SceneInformation total_information(std::span<const SceneInformation> scenes);

/// Dependence between lidar and cameras as a function of T_refcam_lidar, over a fixed set of
/// points.
///
/// Overlap guard: a point that the pose moves out of the image keeps the value at the border that
/// it crossed, without a derivative. Otherwise the plug-in estimate rises as points leave the
/// image, up to a degenerate maximum with few points in view.
class Objective {
 public:
  /// All arguments but `terms` must outlive the objective.
  Objective(const VisiblePoints& points, const BlurredImages& images,
            std::span<const RigCamera> cameras, std::span<const Scene> scenes,
            std::span<const TermOptions> terms);

  /// Evaluates the weighted sum of the terms.
  Evaluation evaluate(const Eigen::Isometry3d& T_refcam_lidar, bool with_gradient);

  /// Replaces the images by others of the same sizes, which must outlive this.
  void set_images(const BlurredImages& images) { images_ = &images; }

  /// Replaces the cameras, which must outlive this.
  void set_cameras(std::span<const RigCamera> cameras) { cameras_ = cameras; }

  /// Returns the gradient of each scene's part of the sum, one entry per scene; they add up to
  /// `Evaluation::gradient`. Their spread gives the uncertainty. Of the terms with a gradient. The
  /// sum itself goes to `estimate`, where that is not null.
  std::vector<SceneGradient> scene_gradients(const Eigen::Isometry3d& T_refcam_lidar,
                                             dependence::Estimate* estimate = nullptr);

  /// Samples that one term compares at a pose; of several features the first.
  struct Samples {
    std::vector<float> lidar;  ///< by rank if the term has `equalize`
    std::vector<float> image;  ///< 0 … 1; NaN where the camera's model does not see the point
  };
  Samples samples(const Eigen::Isometry3d& T_refcam_lidar, size_t term);

  /// Returns the information of the points with a gradient at a pose.
  PointInformation information(const Eigen::Isometry3d& T_refcam_lidar);

  size_t point_count() const { return points_.size(); }
  /// Median range of the points, m: a rotation by one radian moves them by about so much.
  double median_range() const;
  /// Number of evaluations so far.
  int evaluations() const { return evaluations_; }

 private:
  struct Term {
    TermOptions options;
    std::unique_ptr<DependenceTerm> dependence;
  };
  void project(const Eigen::Isometry3d& T_refcam_lidar);
  void look_up(const TermOptions& term);
  /// `per_sample`: derivative of each sample's contribution to n times a term, instead of to the
  /// term.
  dependence::Estimate differentiate_pixels(const Eigen::Isometry3d& T_refcam_lidar,
                                            bool with_gradient, bool per_sample = false);
  geometry::Vector6 block_gradient(const VisiblePoints::Block& block,
                                   const Eigen::Isometry3d& T_refcam_lidar) const;
  /// Derivatives of the pixel of point `i`, at `p` in the camera, by the camera's model.
  Eigen::Matrix<double, 2, 4> pixel_by_camera(const CameraIntrinsics& camera, size_t i,
                                              const Eigen::Vector3d& p) const;
  Eigen::Vector4d camera_gradient(const VisiblePoints::Block& block,
                                  const Eigen::Isometry3d& T_refcam_lidar) const;

  const VisiblePoints& points_;
  const BlurredImages* images_;
  std::span<const RigCamera> cameras_;
  std::span<const Scene> scenes_;
  std::vector<Term> terms_;
  int evaluations_ = 0;

  // Scratch, one entry per point; of values one per point and image feature.
  std::vector<float> u_, v_, depth_;
  std::vector<float> value_, value_by_u_, value_by_v_;  ///< of the image features looked up last
  std::vector<float> by_value_;                         ///< ∂term/∂value
  std::vector<float> by_u_, by_v_;                      ///< ∂sum/∂pixel
};

}  // namespace infuse::calibration
