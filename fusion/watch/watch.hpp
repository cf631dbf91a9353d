#pragma once

#include <optional>
#include <string>

#include "fusion/watch/camera_check.hpp"
#include "fusion/watch/delay_ambiguity.hpp"
#include "fusion/watch/drift_test.hpp"
#include "fusion/watch/quick_dependence.hpp"
#include "fusion/watch/scene_store.hpp"

namespace infuse::watch {

/// Settings of the watch of one camera.
struct WatchOptions {
  double rotation_step = 8.7e-3;   ///< rad; how far around the calibration the dependence is asked
  double far_step = 0.026;         ///< rad; the same for the wide look
  double translation_step = 0.06;  ///< m
  double time_step = 0.08;         ///< s
  double far_time_step = 0.2;      ///< s
  double focal_samples = 300;      ///< focal length of the reduced picture, samples
  size_t max_points = 8000;        ///< returns that take part in a look
  size_t min_points = 500;         ///< with fewer a picture is passed over
  double interval = 0.38;          ///< s; looks are at least so far apart
  double spacing = 1.5;            ///< m driven, or
  double turning = 0.1;            ///< rad turned between two looks: a place is looked at once
  double least_peak = 4e-3;        ///< nats; with less between top and foot a picture says nothing
  QuickDependence::Weights weights;
  DriftTestOptions test;
  CameraCheckOptions check;
  SceneStoreOptions store;

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// What the evidence says of the present calibration.
enum class Drift : uint8_t {
  kLearning,  ///< too few looks yet
  kHolds,
  kSuspect,  ///< evidence for a drift, not enough to be certain
  kDrifted,
};

/// What one picture added.
struct WatchReport {
  Stamp stamp;
  bool looked = false;      ///< the picture was put to the test
  const char* reason = "";  ///< static text: why it was not
  CameraFault fault = CameraFault::kNone;
  Drift drift = Drift::kLearning;
  Axis axis = Axis::kRotationX;  ///< with the most evidence
  double evidence = 0;           ///< nats, along it
  /// Where the calibration seems to be off: how far the present T_camera_lidar lies from the top of
  /// the dependence, over late looks, (rx, ry, rz, tx, ty, tz).
  geometry::Vector6 offset = geometry::Vector6::Zero();
  geometry::Vector6 deviation = geometry::Vector6::Zero();  ///< of it, one standard deviation
  double delay = 0;  ///< s; how much later the camera's stamps seem to be than its exposures
  std::optional<Axis> delay_alike;  ///< along which such a delay cannot be told from a moved camera
  double dependence = 0;            ///< nats, of this picture at the present calibration
  /// Nats; how much more that is than at the alternative (`set_alternative`).
  double gain = 0;
  bool has_gain = false;
  Stamp since;        ///< drift can have begun here: the evidence was nil; earliest without one
  bool kept = false;  ///< the scene store took it
};

/// Watches the calibration of one camera to one lidar while driving. Of one thread; pure; allocates
/// nothing once it has seen the largest picture and sweep and the store is full.
///
/// A look asks the dependence (`QuickDependence`) at the present calibration and a step to both
/// sides along every `Axis`: three rotations, three translations, the time by which the camera
/// would be late (the motion meanwhile), and rotations and time with a wider step. `DriftTest` adds
/// up what the parabolas through three values say.
class Watch {
 public:
  /// `options.invalid()` and `camera.invalid()` must be empty.
  Watch(const CameraIntrinsics& camera, const Eigen::Isometry3d& T_camera_lidar,
        const WatchOptions& options);

  /// Takes a picture (kGrey8) and the returns of its sweep as of its exposure.
  WatchReport take(const CameraFrame& grey, const SweepView& sweep, const Motion& motion);

  /// The calibration was changed: evidence starts anew.
  void set_calibration(const Eigen::Isometry3d& T_camera_lidar);

  /// The calibration in use is another, and the watch is not told: for tests of how soon it
  /// notices.
  void misplace(const Eigen::Isometry3d& T_camera_lidar) { T_camera_lidar_ = T_camera_lidar; }

  /// Another calibration that each look is compared with (`WatchReport::gain`), or none.
  void set_alternative(const std::optional<Eigen::Isometry3d>& T_camera_lidar);

  const Eigen::Isometry3d& T_camera_lidar() const { return T_camera_lidar_; }
  const SceneStore& scenes() const { return store_; }
  /// For what is known to be outdated.
  SceneStore& scenes() { return store_; }
  const DriftTest& test() const { return test_; }

 private:
  const char* why_not(const CameraFrame& grey, const Motion& motion);
  AxisLook look(const Motion& motion, WatchReport& report);
  double step_along(Axis axis) const;
  void judge(WatchReport& report);
  void travel(Stamp stamp, const Motion& motion);

  WatchOptions options_;
  geometry::CameraModel camera_;
  int step_;
  Eigen::Isometry3d T_camera_lidar_;
  std::optional<Eigen::Isometry3d> alternative_;
  QuickPicture picture_;
  QuickPoints points_;
  QuickDependence dependence_;
  DriftTest test_;
  DelayAmbiguity ambiguity_;
  CameraCheck check_;
  SceneStore store_;
  std::optional<Stamp> last_stamp_, last_look_;
  double travelled_ = 0, turned_ = 0;                   // since the beginning
  double looked_travelled_ = -1e9, looked_turned_ = 0;  // at the last look
  Stamp quiet_ = Stamp::earliest();                     // when evidence was nil
};

}  // namespace infuse::watch
