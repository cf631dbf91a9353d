#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <span>
#include <vector>

#include "fusion/calibration/dependence_term.hpp"
#include "fusion/calibration/scene.hpp"
#include "fusion/calibration/visible_points.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::calibration {

/// The image features of all scenes, blurred alike and thinned as the blur allows: made once a
/// level of a coarse-to-fine search, shared by all its hypotheses.
class BlurredImages {
 public:
  /// `sigma`: of the Gaussian, pixels.
  BlurredImages(std::span<const Scene> scenes, std::span<const TermOptions> terms, double sigma);

  /// The same from images that are blurred less: cheaper.
  BlurredImages(const BlurredImages& finer, double sigma);

  const features::Plane& plane(size_t scene, ImageFeature feature) const {
    return feature == ImageFeature::kLocalGrey ? local_grey_[scene]
                                               : blurred_[scene][index(feature)];
  }

  /// The same pictures dealt out to other scenes: scene s gets that of scene `from[s]`.
  BlurredImages permuted(std::span<const size_t> source_scenes) const;

 private:
  BlurredImages() = default;

  /// Local grey from the blurred grey.
  void make_local_grey();

  std::vector<PerImageFeature<features::Plane>> blurred_;  ///< from which more blurred ones are made
  std::vector<features::Plane> local_grey_;                ///< a scene each, where a term asks for it
  double sigma_ = 0;
};

/// The measure at one hypothesis.
struct Evaluation {
  dependence::Estimate estimate;
  /// ∂value/∂ξ, ξ a left perturbation of T_head_lidar (rx, ry, rz, tx, ty, tz; rad, m).
  geometry::Vector6 gradient = geometry::Vector6::Zero();
};

/// How a scene's part of the objective changes with the pose (six entries, as Evaluation::gradient)
/// and with its camera's model: with the logarithm of the focal lengths, the principal point (u, v,
/// px) and the first radial distortion coefficient.
using SceneGradient = Eigen::Matrix<double, 10, 1>;

/// The dependence of lidar and camera as a function of T_head_lidar, over a fixed set of points.
///
/// Overlap guard: a point that the hypothesis moves out of the picture keeps the value at the
/// border that it crossed, without a derivative. It cannot raise the measure by vanishing, which is
/// how the plug-in estimate otherwise finds its degenerate maximum (few points in view).
class Objective {
 public:
  /// All arguments but `terms` must outlive the objective.
  Objective(const VisiblePoints& points, const BlurredImages& images,
            std::span<const RigCamera> cameras, std::span<const Scene> scenes,
            std::span<const TermOptions> terms);

  /// The weighted sum of the terms.
  Evaluation evaluate(const Eigen::Isometry3d& T_head_lidar, bool with_gradient);

  /// Has the points look at other pictures from now on, of the same sizes; they must outlive this.
  void set_images(const BlurredImages& images) { images_ = &images; }

  /// Has the points seen by other cameras from now on; they must outlive this.
  void set_cameras(std::span<const RigCamera> cameras) { cameras_ = cameras; }

  /// The gradient of each scene's part of the sum, an entry a scene; they add up to `gradient`.
  /// For the terms with a gradient: how the scenes pull, whose spread tells the uncertainty.
  /// The sum itself goes to `estimate`, where that is given.
  std::vector<SceneGradient> scene_gradients(const Eigen::Isometry3d& T_head_lidar,
                                             dependence::Estimate* estimate = nullptr);

  /// The samples of one term at a pose that take part: what its measure is asked about. Of several
  /// features the first.
  struct Samples {
    std::vector<float> lidar;  ///< by rank where the term says so
    std::vector<float> image;  ///< 0 … 1; NaN where the camera's model does not see the point
  };
  Samples samples(const Eigen::Isometry3d& T_head_lidar, size_t term);

  /// Fisher's information P(3.19) of the sum at a pose, Σᵢ sᵢ sᵢᵀ over the points: sᵢ is the
  /// derivative by the pose of point i's part of each term times the term's samples, for mutual
  /// information that of log p(x, y) / (p(x) p(y)). For the terms with a gradient.
  geometry::Matrix6 information(const Eigen::Isometry3d& T_head_lidar);

  size_t point_count() const { return points_.size(); }
  /// Of the points, m: so far a translation goes that moves them as an angle of one does.
  double median_range() const;
  /// Evaluations so far.
  int evaluations() const { return evaluations_; }

 private:
  struct Term {
    TermOptions options;
    std::unique_ptr<DependenceTerm> dependence;
  };
  void project(const Eigen::Isometry3d& T_head_lidar);
  void look_up(const TermOptions& term);
  /// `of_samples`: what each sample adds to n times a term, in place of what it adds to the term.
  dependence::Estimate differentiate_pixels(const Eigen::Isometry3d& T_head_lidar,
                                            bool with_gradient, bool per_sample = false);
  geometry::Vector6 block_gradient(const VisiblePoints::Block& block,
                                   const Eigen::Isometry3d& T_head_lidar) const;
  Eigen::Vector4d camera_gradient(const VisiblePoints::Block& block,
                                  const Eigen::Isometry3d& T_head_lidar) const;

  const VisiblePoints& points_;
  const BlurredImages* images_;
  std::span<const RigCamera> cameras_;
  std::span<const Scene> scenes_;
  std::vector<Term> terms_;
  int evaluations_ = 0;

  // Scratch, one entry a point; of values one a point and image feature.
  std::vector<float> u_, v_, depth_;
  std::vector<float> value_, value_by_u_, value_by_v_;  ///< of the image feature looked up last
  std::vector<float> by_value_;                         ///< ∂term/∂value
  std::vector<float> by_u_, by_v_;                      ///< ∂sum/∂pixel
};

}  // namespace infuse::calibration
