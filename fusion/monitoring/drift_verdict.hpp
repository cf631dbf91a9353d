#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/monitoring/axis.hpp"
#include "fusion/monitoring/camera_fault.hpp"

namespace infuse::monitoring {

/// State of the evidence against the present calibration.
enum class Drift : uint8_t {
  kLearning,  ///< too few evaluations so far
  kHolds,
  kSuspected,  ///< evidence for a drift, below the confirmation threshold
  kConfirmed,
};

/// Verdict on a calibration: the one type from the detector to the reports.
struct DriftVerdict {
  Drift drift = Drift::kLearning;     ///< the state
  Axis axis = Axis::kRotationX;       ///< axis with the most evidence, not a wide variant
  double evidence = 0;                ///< nats, along that axis
  double threshold = 0;               ///< nats, at which a drift is confirmed
  Axis runner_up = Axis::kRotationX;  ///< axis with the most evidence of the others
  double runner_up_evidence = 0;      ///< nats; the difference is the logarithm of the odds
  /// Estimated error of the present T_camera_lidar: its offset from the maximum of the dependence,
  /// over recent evaluations, (rx, ry, rz, tx, ty, tz), rad and m.
  geometry::Vector6 offset = geometry::Vector6::Zero();
  geometry::Vector6 sigma = geometry::Vector6::Zero();  ///< standard deviation of `offset`
  bool at_least = false;  ///< the offset is a lower bound: the maximum lies farther away
  double delay = 0;       ///< s; estimated delay of the camera's stamps after its exposures
  /// Axis along which a delay cannot be separated from a displaced camera.
  std::optional<Axis> delay_ambiguous_axis;
  CameraFault fault = CameraFault::kNone;  ///< beside the pose
  std::string images_of;  ///< the camera of the rig whose images they are, if swapped

  /// True if a drift is suspected or confirmed.
  bool drifting() const { return drift == Drift::kSuspected || drift == Drift::kConfirmed; }

  /// Sets the fault that the images show. Without one they may be those of `other`, a camera of the
  /// rig, unless that is empty; and a confirmed drift along time is a late camera.
  void set_fault(CameraFault observed, const std::string& other = {});
};

/// Describes an offset (rad or m) along an axis of a pose: "rotation about y by +0.52 ± 0.03°".
std::string describe_offset(Axis axis, double offset, double sigma);

/// Describes the drift: "rotation about y by +0.52 ± 0.03° (evidence 20.4, threshold 19.1 nats)".
std::string describe_drift(const DriftVerdict& verdict);

/// Describes the fault: "black", or "swapped: its images are those of the camera left".
std::string describe_fault(const DriftVerdict& verdict);

}  // namespace infuse::monitoring
