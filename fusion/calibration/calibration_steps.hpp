#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include "fusion/calibration/calibrate.hpp"

namespace infuse::calibration {

/// Returns true if two ascents ended at the same maximum: within 0.3° and 4 cm.
bool is_same_maximum(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b);

/// State that the steps of a calibration (`calibrate`) share. Poses are T_refcam_lidar.
class CalibrationSteps {
 public:
  /// The arguments of `calibrate`; `cameras` and `options` must outlive it.
  CalibrationSteps(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                   const Eigen::Isometry3d& initial_pose, const CalibrateOptions& options);

  /// Search of the last level, by the terms that are maximised.
  CoarseToFine& final_search() { return final_search_; }
  /// Search of the fine levels before it, by the search terms.
  CoarseToFine& fine_search() { return fine_search_; }
  /// Similarity of each two scenes (`scene_similarity`).
  const Eigen::MatrixXd& similarity() const { return similarity_; }
  /// Number of independent scenes that these count as.
  double effective_scenes() const;

  /// Pose after the restarts, and how many of the last round converged to it.
  struct RestartResult {
    Eigen::Isometry3d T;           ///< T_refcam_lidar
    int restarts = 0;              ///< number of ascents of the last round
    int converged_restarts = 0;    ///< of these, how many converged to `T`
    bool best_of_restarts = true;  ///< the last round found no larger value
  };

  /// Returns the best result of the coarse levels; `prior_scale` multiplies their prior weights.
  Eigen::Isometry3d find_basin(double prior_scale);

  /// Ascends from poses around `T`; repeats this around a better result, where one is found.
  /// Returns the best pose and how many ascents of the last round converged to it.
  RestartResult run_restarts(const Eigen::Isometry3d& T);

  /// Ascends at the finest blur from `T` and from poses around it. Returns the end with the largest
  /// measure, on the points in view at `T`; nothing if that is at the maximum that `T` leads to.
  std::optional<Eigen::Isometry3d> run_fine_restarts(const Eigen::Isometry3d& T);

  /// Covariance from random halves of the scenes: ¼ mean of the squared difference of their
  /// results.
  std::optional<geometry::Matrix6> split_half(const Eigen::Isometry3d& T);

  /// Estimates each camera's intrinsics together with the pose.
  std::vector<std::optional<IntrinsicsEstimate>> estimate_all_intrinsics(
      const Eigen::Isometry3d& T, const Uncertainty& uncertainty);

  /// Finds errors of the intrinsics and the clock that the scenes indicate.
  std::vector<ParameterCheck> check_parameters(
      const Eigen::Isometry3d& T, const Uncertainty& uncertainty,
      std::span<const std::optional<IntrinsicsEstimate>> estimates) const;

  /// Delay of the images, s, that displaces the reference camera as far along the driving direction
  /// as it lies from its initial position; nothing if that is near or in another direction.
  std::optional<double> delay_along_travel(const Eigen::Isometry3d& T) const;

  /// Number of evaluations of the objective so far.
  int evaluations() const;

 private:
  /// `thin_scenes` around the initial pose; scenes of a frequent place keep fewer points.
  std::vector<Scene> thin(std::span<const Scene> scenes, size_t points,
                          bool keep_edges = false) const;
  /// Sets `unseen_sigma` and `detection_limit` of a camera's intrinsics, in the order of
  /// `check_model`.
  void set_limits(const std::optional<IntrinsicsEstimate>& estimate, size_t camera,
                  std::vector<ParameterCheck>& all) const;
  /// Returns the two finest of the coarse levels.
  std::span<const Level> restart_levels() const;
  /// Poses to draw, evenly within half widths of each axis, rad and m, and the blur to score them.
  struct Draw {
    int restarts;
    double rotation, translation;
    double sigma;
  };
  /// Draws many poses around `T` and returns those where the points in view at `T` fit best.
  std::vector<Eigen::Isometry3d> draw_around(const Eigen::Isometry3d& T, const Draw& draw,
                                             std::mt19937_64& random);
  /// Ascends through `restart_levels`, until it has arrived at `result`.
  Eigen::Isometry3d restart_from(const Eigen::Isometry3d& drawn, const Eigen::Isometry3d& result);
  /// Ascends the finest coarse level with some of the scenes alone.
  Eigen::Isometry3d ascend_with_scenes(const Eigen::Isometry3d& T, std::span<const size_t> scenes);
  /// Ascends one level from each pose; returns the best of the different maxima, best first.
  std::vector<Eigen::Isometry3d> ascend_from_all(const std::vector<Eigen::Isometry3d>& from,
                                                 const Level& level);

  Eigen::Vector3d prior_position() const { return initial_pose_.inverse().translation(); }

  std::span<const RigCamera> cameras_;
  Eigen::Isometry3d initial_pose_;
  const CalibrateOptions& options_;
  Eigen::MatrixXd similarity_;
  Eigen::VectorXd weights_;  // `scene_weights`
  std::vector<TermOptions> terms_, search_terms_;
  ImagePyramid images_;
  double margin_;
  std::vector<Scene> screening_scenes_, coarse_scenes_, fine_scenes_;
  CoarseToFine final_search_, fine_search_, coarse_search_;
  int evaluations_ = 0;
};

}  // namespace infuse::calibration
