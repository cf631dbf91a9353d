#pragma once

#include <optional>
#include <string>

#include "fusion/monitoring/camera_check.hpp"
#include "fusion/monitoring/delay_ambiguity.hpp"
#include "fusion/monitoring/drift_detector.hpp"
#include "fusion/monitoring/monitor_dependence.hpp"
#include "fusion/monitoring/scene_store.hpp"

namespace infuse::monitoring {

/// Settings of the watch of one camera.
struct MonitorOptions {
  double rotation_step = 8.7e-3;  ///< rad; how far around the calibration the dependence is asked
  double wide_rotation_step = 0.026;  ///< rad; the same for the wide look
  double translation_step = 0.06;     ///< m
  double time_step = 0.08;            ///< s
  double wide_time_step = 0.2;        ///< s
  double reduced_focal_length = 300;  ///< focal length of the reduced picture, samples
  size_t max_points = 8000;           ///< returns that take part in a look
  size_t min_points = 500;            ///< with fewer a picture is passed over
  double min_interval = 0.38;         ///< s; looks are at least so far apart
  double min_distance = 1.5;          ///< m driven, or
  double min_rotation = 0.1;          ///< rad turned between two looks: a place is looked at once
  double min_peak = 4e-3;  ///< nats; with less between top and foot a picture says nothing
  MonitorDependence::Weights weights;
  DriftDetectorOptions detector;
  CameraCheckOptions camera_check;
  SceneStoreOptions scene_store;

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// What the evidence says of the present calibration.
enum class Drift : uint8_t {
  kLearning,  ///< too few looks yet
  kHolds,
  kSuspected,  ///< evidence for a drift, not enough to be certain
  kConfirmed,
};

/// What one picture added.
struct MonitorReport {
  Stamp stamp;
  bool evaluated = false;   ///< the picture was put to the test
  const char* reason = "";  ///< static text: why it was not
  CameraFault fault = CameraFault::kNone;
  Drift drift = Drift::kLearning;
  Axis axis = Axis::kRotationX;  ///< with the most evidence
  double evidence = 0;           ///< nats, along it
  /// Where the calibration seems to be off: how far the present T_camera_lidar lies from the top of
  /// the dependence, over late looks, (rx, ry, rz, tx, ty, tz).
  geometry::Vector6 offset = geometry::Vector6::Zero();
  geometry::Vector6 sigma = geometry::Vector6::Zero();  ///< of it, one standard deviation
  double delay = 0;  ///< s; how much later the camera's stamps seem to be than its exposures
  std::optional<Axis>
      delay_ambiguous_axis;  ///< along which such a delay cannot be told from a moved camera
  double dependence = 0;     ///< nats, of this picture at the present calibration
  /// Nats; how much more that is than at the alternative (`set_alternative`).
  double gain = 0;
  bool has_gain = false;
  Stamp since;          ///< drift can have begun here: the evidence was nil; earliest without one
  bool stored = false;  ///< the scene store took it
};

/// Watches the calibration of one camera to one lidar while driving. Of one thread; pure; allocates
/// nothing once it has seen the largest picture and sweep and the store is full.
///
/// A look asks the dependence (`MonitorDependence`) at the present calibration and a step to both
/// sides along every `Axis`: three rotations, three translations, the time by which the camera
/// would be late (the motion meanwhile), and rotations and time with a wider step. `DriftDetector`
/// adds up what the parabolas through three values say.
class CalibrationMonitor {
 public:
  /// `options.invalid()` and `camera.invalid()` must be empty.
  CalibrationMonitor(const CameraIntrinsics& camera, const Eigen::Isometry3d& T_camera_lidar,
                     const MonitorOptions& options);

  /// Takes a picture (kGrey8) and the returns of its sweep as of its exposure.
  MonitorReport process(const CameraFrame& grey, const SweepView& sweep, const Motion& motion);

  /// The calibration was changed: evidence starts anew.
  void set_calibration(const Eigen::Isometry3d& T_camera_lidar);

  /// The calibration in use is another, and the watch is not told: for tests of how soon it
  /// notices.
  void inject_miscalibration(const Eigen::Isometry3d& T_camera_lidar) {
    T_camera_lidar_ = T_camera_lidar;
  }

  /// Another calibration that each look is compared with (`MonitorReport::gain`), or none.
  void set_alternative(const std::optional<Eigen::Isometry3d>& T_camera_lidar);

  const Eigen::Isometry3d& T_camera_lidar() const { return T_camera_lidar_; }
  const SceneStore& scenes() const { return scene_store_; }
  /// For what is known to be outdated.
  SceneStore& scenes() { return scene_store_; }
  const DriftDetector& detector() const { return detector_; }

 private:
  const char* reason_to_skip(const CameraFrame& grey, const Motion& motion);
  AxisEvaluation evaluate_axes(const Motion& motion, MonitorReport& report);
  double step_for(Axis axis) const;
  void fill_report(MonitorReport& report);
  void accumulate_motion(Stamp stamp, const Motion& motion);

  MonitorOptions options_;
  geometry::CameraModel camera_;
  int step_;
  Eigen::Isometry3d T_camera_lidar_;
  std::optional<Eigen::Isometry3d> alternative_;
  features::RingDirections rings_;
  MonitorImage image_;
  MonitorPoints points_;
  MonitorDependence dependence_;
  DriftDetector detector_;
  DelayAmbiguity ambiguity_;
  CameraCheck camera_check_;
  SceneStore scene_store_;
  std::optional<Stamp> last_stamp_, last_evaluation_;
  double travelled_ = 0, turned_ = 0;                                 // since the beginning
  double travelled_at_evaluation_ = -1e9, turned_at_evaluation_ = 0;  // at the last look
  Stamp last_without_evidence_ = Stamp::earliest();                   // when evidence was nil
};

}  // namespace infuse::monitoring
