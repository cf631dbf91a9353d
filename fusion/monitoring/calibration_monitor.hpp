#pragma once

#include <optional>
#include <stop_token>
#include <string>

#include "fusion/monitoring/camera_assignment.hpp"
#include "fusion/monitoring/camera_check.hpp"
#include "fusion/monitoring/delay_ambiguity.hpp"
#include "fusion/monitoring/drift_detector.hpp"
#include "fusion/monitoring/drift_search.hpp"
#include "fusion/monitoring/monitor_dependence.hpp"
#include "fusion/monitoring/scene_store.hpp"

namespace infuse::monitoring {

/// Settings of the monitoring of one camera.
struct MonitorOptions {
  double rotation_step = 8.7e-3;         ///< rad; step around the calibration for the evaluation
  double wide_rotation_step = 0.0214;    ///< rad; derived from the two beside: geometric mean
  double far_rotation_step = 0.0524;     ///< rad; the same with a blurred image
  double farther_rotation_step = 0.105;  ///< rad; derived from the one before: twice as far
  double translation_step = 0.06;        ///< m; the same for translations
  double time_step = 0.08;               ///< s; the same for the delay of the camera's stamps
  double wide_time_step = 0.2;           ///< s; the same for the wide evaluation
  double reduced_focal_length = 300;     ///< focal length of the reduced image, samples
  size_t max_points = 8000;              ///< maximum number of returns of an evaluation
  size_t min_points = 500;               ///< minimum number of returns of an evaluation
  double min_interval = 0.38;            ///< s; minimum time between evaluations
  double min_distance = 1.5;             ///< m driven, or
  double min_rotation = 0.1;  ///< rad turned between evaluations: each place is evaluated once
  double min_peak = 4e-3;  ///< nats; minimum difference between the largest and the smallest value
  MonitorDependence::Weights weights;  ///< of its parts
  DriftDetectorOptions detector;       ///< of the evidence
  /// The caller runs the searches of drifts (`search_due`); false: they are part of `process`.
  bool background_search = false;
  CameraCheckOptions camera_check;  ///< of faults
  SceneStoreOptions scene_store;    ///< of scenes that are kept

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Result of the monitoring of one image.
struct MonitorReport {
  Stamp stamp;              ///< of the image
  bool evaluated = false;   ///< true if the image was evaluated
  const char* reason = "";  ///< static text: why it was not evaluated
  DriftVerdict verdict;     ///< by this image and those before
  double dependence = 0;    ///< nats, of this image at the present calibration
  /// Nats; `dependence` minus that at the alternative (`set_alternative`).
  double gain = 0;
  bool has_gain = false;             ///< there is an alternative
  bool alternative_drifted = false;  ///< a drift of the alternative itself is confirmed
  Stamp alternative_since;           ///< earliest begin of that
  Stamp since;  ///< earliest begin of the drift: last stamp without evidence; `earliest` without a
                ///< drift
  bool stored = false;  ///< true if the scene store keeps the scene
};

/// Monitors the calibration of one camera to one lidar while driving. Single-threaded and pure.
/// Allocates nothing after the largest image and sweep, once the store is full.
///
/// An evaluation computes the dependence (`MonitorDependence`) at the present calibration and one
/// step to both sides along every `Axis`: three rotations, three translations, the delay of the
/// camera (the motion meanwhile), and rotations and delay with a wider step. `DriftDetector`
/// accumulates the parabolas through these values.
///
/// As soon as something speaks against the calibration, `DriftSearch` finds the pose that the last
/// scenes lead to: the amount of the drift. Following scenes compare it with the calibration. The
/// pose was chosen before them, so that the product of their likelihood ratios remains a test of
/// the calibration, whatever the pose (Wald's plug-in ratio).
class CalibrationMonitor {
 public:
  /// `options.invalid()` and `camera.invalid()` must be empty.
  CalibrationMonitor(const CameraIntrinsics& camera, const Eigen::Isometry3d& T_camera_lidar,
                     const MonitorOptions& options);

  /// Processes an image (kGrey8) and the returns of its sweep as of its exposure.
  MonitorReport process(const CameraFrame& grey, const SweepView& sweep, const Motion& motion);

  /// True if a search of the drift is to be begun, and none runs.
  bool search_due() const { return search_due_; }
  /// Begins a search: keeps what it compares.
  void begin_search();
  /// Does the search that was begun; on any thread, beside `process`.
  void run_search(const std::stop_token& stop = {});
  /// Takes the search's result into use.
  void finish_search();

  /// Sets a new calibration and restarts the evidence.
  void set_calibration(const Eigen::Isometry3d& T_camera_lidar);

  /// Compares images with the places of the rig's other cameras too; this one is `camera` there.
  /// Its place is the calibration in use from now on. Outlives the monitor.
  void set_assignment(CameraAssignment& assignment, size_t camera) {
    assignment_ = &assignment;
    camera_of_rig_ = camera;
    assignment_->set_place(camera, T_camera_lidar_);
  }

  /// Replaces the calibration without restarting the evidence: simulates a drift, for tests.
  void inject_miscalibration(const Eigen::Isometry3d& T_camera_lidar) {
    T_camera_lidar_ = T_camera_lidar;
  }

  /// Sets another calibration that is monitored with the same images, and that each evaluation is
  /// compared with (`MonitorReport::gain`); or none.
  void set_alternative(const std::optional<Eigen::Isometry3d>& T_camera_lidar);

  const Eigen::Isometry3d& T_camera_lidar() const { return T_camera_lidar_; }  ///< in use
  const SceneStore& scenes() const { return scene_store_; }                    ///< that are kept
  /// Mutable access, for removing outdated scenes.
  SceneStore& scenes() { return scene_store_; }
  const DriftDetector& detector() const { return detector_; }  ///< the evidence

 private:
  const char* reason_to_skip(const CameraFrame& grey, const Motion& motion);
  /// A calibration, and the evidence against it.
  struct Monitored {
    Eigen::Isometry3d T_camera_lidar;
    DriftDetector detector;
    Stamp last_without_evidence;
  };
  /// Dependence around a calibration.
  struct Surroundings {
    AxisEvaluation axes;
    double centre = 0;  // nats
    double spread = 0;  // nats, the largest difference along an axis
  };
  Surroundings evaluate(const Eigen::Isometry3d& T_camera_lidar, const Motion& motion);
  /// A pose that a search has found, and the evidence of the scenes after it.
  struct Led {
    DriftEstimate estimate;
    Eigen::Isometry3d T_camera_lidar;
    Eigen::Isometry3d T_tolerated;  // on the way there, where the calibration would still hold
    bool matters = false;           // it lies as far away as a drift that is to be detected
    double evidence = 0;            // nats, against the calibration
    double support = 0;             // nats, of the scenes after the first search
    int evaluations = 0;            // since the search
  };
  double led_evidence() const { return led_ && led_->matters ? led_->evidence : 0; }
  void compare_led();
  void compare_places(const SweepView& sweep, double centre);
  void update_search(const Motion& motion);
  void state_drift(DriftVerdict& verdict) const;
  void evaluate_calibrations(const CameraFrame& grey, const SweepView& sweep, const Motion& motion,
                             MonitorReport& report);
  double step_for(Axis axis) const;
  void fill_report(MonitorReport& report);
  void accumulate_motion(Stamp stamp, const Motion& motion);

  MonitorOptions options_;
  geometry::CameraModel camera_;
  int step_;
  Eigen::Isometry3d T_camera_lidar_;
  std::optional<Monitored> alternative_;
  std::optional<Led> led_;
  features::RingDirections rings_;
  MonitorImage image_;
  MonitorPoints points_;
  MonitorDependence dependence_;
  DriftDetector detector_;
  /// A search of the drift, and its result.
  struct SearchJob {
    Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();
    std::optional<geometry::Vector6> known;
    size_t scenes = 0;
    double noise = 1;
    DriftEstimate found;
    bool outdated = false;  // the calibration has changed meanwhile
  };
  DriftSearch search_;  // while a search runs, its thread's
  SearchJob job_;
  bool searching_ = false, search_due_ = false;
  DelayAmbiguity ambiguity_;
  CameraCheck camera_check_;
  CameraAssignment* assignment_ = nullptr;
  size_t camera_of_rig_ = 0;
  SceneStore scene_store_;
  std::optional<Stamp> last_stamp_, last_evaluation_;
  double travelled_ = 0, turned_ = 0;                                 // since the beginning
  double travelled_at_evaluation_ = -1e9, turned_at_evaluation_ = 0;  // at the last evaluation
  Stamp last_without_evidence_ = Stamp::earliest();                   // last stamp without evidence
};

}  // namespace infuse::monitoring
