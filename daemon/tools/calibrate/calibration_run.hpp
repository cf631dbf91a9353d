#pragma once

#include <optional>
#include <random>
#include <string>
#include <vector>

#include "daemon/playback/calibration_scenes.hpp"
#include "daemon/tools/calibrate/motion_uncertainty.hpp"
#include "fusion/calibration/any_heading.hpp"
#include "fusion/calibration/calibrate.hpp"
#include "fusion/calibration/named_measures.hpp"
#include "fusion/calibration/refine_delay.hpp"
#include "fusion/calibration/refine_intrinsics.hpp"

namespace infuse::daemon {

/// What a calibration estimates.
enum class CalibrationKind : uint8_t {
  kPose,        ///< the pose, from a guess of all of it
  kAnyHeading,  ///< the pose, without a guess of the heading
  kIntrinsics,  ///< the pose and the intrinsics of the cameras
  kDelay,       ///< the pose and the delay of the camera's stamps
};

/// A calibration with one measure, and its input.
struct CalibrationRun {
  std::string measure;
  std::vector<calibration::Scene> scenes;
  std::vector<calibration::RigCamera>
      cameras;  ///< the cameras of the rig, the reference camera first
  Eigen::Isometry3d initial_pose = Eigen::Isometry3d::Identity();  ///< T_camera_lidar
  calibration::CalibrateOptions options;
  calibration::CalibrationResult result;  ///< its covariance includes `motion`
  MotionUncertainty motion;
  /// With `--refine-intrinsics`; `cameras` have the refined ones, its result is `result`.
  std::optional<calibration::RefinedCalibration> refined;
  /// With `--refine-delay`; its result is `result`.
  std::optional<calibration::DelayCalibration> delay;
  double cpu_s = 0;
};

/// Returns `T` perturbed at random, uniformly within ±`angle` (rad) about and ±`length` (m) along
/// each axis.
Eigen::Isometry3d perturb(const Eigen::Isometry3d& T, double angle, double length,
                          std::mt19937_64& random);

/// One camera of the pairs.
calibration::RigCamera rig_camera(const ScenePairs& pairs, size_t camera);

/// The cameras of the pairs, the reference camera first.
std::vector<calibration::RigCamera> rig_cameras(const ScenePairs& pairs);

/// Makes the scene of one pair, with the features that `measure` compares; `T_refcam_lidar` directs
/// image edges along the rings. Errors: a pair from which no scene can be made.
Result<calibration::Scene> make_scene(const ScenePairs& pairs, const ScenePair& pair,
                                      const calibration::NamedMeasure& measure,
                                      const Eigen::Isometry3d& T_refcam_lidar);

/// Makes a scene of every pair, with the features that `measure` compares; `T_refcam_lidar`
/// directs image edges along the rings. Errors: a pair from which no scene can be made.
Result<std::vector<calibration::Scene>> make_scenes(const ScenePairs& pairs,
                                                    const calibration::NamedMeasure& measure,
                                                    const Eigen::Isometry3d& T_refcam_lidar);

/// Calibrates with a named measure, and what `kind` names. `scenes` has the pairs' scenes, in their
/// order.
CalibrationRun run_calibration(const ScenePairs& pairs, std::vector<calibration::Scene> scenes,
                               const calibration::NamedMeasure& measure,
                               const Eigen::Isometry3d& initial_pose,
                               const calibration::CalibrateOptions& options,
                               CalibrationKind kind = CalibrationKind::kPose);

/// The same with scenes that are made of the pairs' data. Errors: a pair from which no scene can be
/// made.
Result<CalibrationRun> run_calibration(const ScenePairs& pairs,
                                       const calibration::NamedMeasure& measure,
                                       const Eigen::Isometry3d& initial_pose,
                                       const calibration::CalibrateOptions& options,
                                       CalibrationKind kind = CalibrationKind::kPose);

/// Returns the camera's delay as the run estimates it (s), if it does.
std::optional<double> refined_delay(const CalibrationRun& run, const ScenePairs& pairs);

}  // namespace infuse::daemon
