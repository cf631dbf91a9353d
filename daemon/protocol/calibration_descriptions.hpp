#pragma once

#include "daemon/protocol/description_parts.hpp"

namespace infuse::daemon {

// CALIBRATION: its parts, and the message itself.

/// The evidence of a verdict.
struct DriftEvidence {
  monitoring::DriftVerdict verdict;
};

template <class Visitor>
void describe(Visitor& v, const DriftEvidence& evidence) {
  v.field("axis", monitoring::name_of(evidence.verdict.axis));
  v.field("nats", non_negative(rounded(evidence.verdict.evidence)));
  v.field("threshold_nats", non_negative(rounded(evidence.verdict.threshold)),
          "at which drift is confirmed");
  const bool other = evidence.verdict.runner_up_evidence > 0;
  v.field("runner_up",
          when(other, std::string_view(monitoring::name_of(evidence.verdict.runner_up))),
          "axis with the most evidence of the others");
  v.field("runner_up_nats", when(other, non_negative(rounded(evidence.verdict.runner_up_evidence))),
          "the difference of the two is the logarithm of their odds");
}

template <class Visitor>
void describe(Visitor& v, const CalibrationEstimate& estimate) {
  v.field("T_camera_lidar", estimate.T_camera_lidar, "by row, m");
  v.field("covariance", estimate.covariance, kCovarianceText);
  v.field("mahalanobis_distance", non_negative(rounded(estimate.mahalanobis_distance)),
          "from the calibration that was in use");
  v.field("scenes", estimate.scenes, "used by the re-estimation");
  v.field("usable", estimate.reason.empty());
  v.field("reason", unless_empty(estimate.reason), "why it is not usable");
}

template <class Visitor>
void describe(Visitor& v, const CalibrationChange& change) {
  v.field("stamp", change.stamp, "ns");
  v.field("state", change.state, "after the change");
  v.field("what", change.what);
  v.field("T_camera_lidar", change.T_camera_lidar, "in use after the change; by row, m");
}

template <class Visitor>
void describe(Visitor& v, const KnownCalibration& known) {
  v.field("number", positive(known.number), "of infuse apply; kept over restarts");
  v.field("stamp", known.stamp, "since when it is known, ns");
  v.field("origin", known.origin);
  v.field("use", known.use);
  v.field("T_camera_lidar", known.T_camera_lidar, "by row, m");
  v.field("covariance", known.covariance, kCovarianceText);
  v.field("estimated_from", known.estimated_from, "number of the calibration in use then");
}

/// Number of the calibration with a use; nothing if there is none.
inline std::optional<uint64_t> number_of(const CalibrationReport& report, CalibrationUse use) {
  for (const KnownCalibration& known : report.known) {
    if (known.use == use) return known.number;
  }
  return std::nullopt;
}

template <class Visitor>
void describe(Visitor& v, const CalibrationReport& report) {
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  const monitoring::DriftVerdict& verdict = report.verdict;
  const bool evaluated = report.evaluations > 0;
  const Vector6 sigma =
      verdict.sigma.unaryExpr([](double s) { return std::isfinite(s) ? s : 1e9; });
  v.message(name_of(report.kClass),
            "Calibration of a camera to its lidar, every ten seconds and on every change.");
  v.field("stamp", report.stamp, kStampText);
  v.field("device", report.camera, "the camera");
  v.field("state", report.state);
  v.field("since", report.since, "begin of the state, ns");
  v.field("policy", report.policy, "what is done with a new estimate");
  v.field("frozen", report.frozen, "no automatic changes");
  v.field("proposed", report.proposal.has_value(),
          "a new calibration waits for the owner: infuse apply");
  v.field("can_roll_back", number_of(report, CalibrationUse::kPrevious).has_value(),
          "there is a calibration before the one in use: infuse rollback");
  v.field("recalibration_requested", report.recalibration_requested,
          "by the owner; it waits for scenes");
  v.field("number", number_of(report, CalibrationUse::kInUse), "of the calibration in use");
  v.field("T_camera_lidar", report.T_camera_lidar, "in use; by row, m");
  v.field("evaluations", report.evaluations, "images evaluated");
  v.field("scenes", report.scenes, "stored for a re-estimation");
  v.field("needed_scenes", report.needed_scenes, "by the next re-estimation");
  v.field("evidence", when(evaluated, DriftEvidence{verdict}),
          "for a drift, along the axis with the most; absent before the first evaluation");
  v.field("offset", when(evaluated, verdict.offset),
          "estimated error of the calibration in use: rx ry rz tx ty tz about and along the "
          "camera's axes, rad and m; T_camera_lidar in use = exp(offset) times the true one");
  v.field("offset_at_least", evaluated && verdict.at_least,
          "the offset is a lower bound: the camera is turned by more than can be measured");
  v.field("offset_sigma", when(evaluated, sigma), "its standard deviations; 1e9 where unknown");
  v.field("delay_s", when(evaluated, rounded(verdict.delay)),
          "estimated delay of the camera's stamps after its exposures");
  v.field("delay_ambiguous_axis",
          evaluated && verdict.delay_ambiguous_axis
              ? unless_empty(monitoring::name_of(*verdict.delay_ambiguous_axis))
              : std::nullopt,
          "axis along which such a delay is indistinguishable from a moved camera at the recent "
          "motion: rotation about y in a steady turn, translation along z at a steady speed");
  v.field("dependence_nats", when(evaluated, report.dependence), "of the last evaluated image");
  v.field("camera_fault", when(verdict.fault != monitoring::CameraFault::kNone, verdict.fault));
  v.field("images_of", unless_empty(verdict.images_of),
          "the camera whose images these are, of a swapped camera; \"a or b\" where it is not "
          "known which");
  v.field("estimate", report.estimate, "the last re-estimation");
  v.field("history", report.history, "the last changes, oldest first");
  v.field("calibrations", report.known, "that were in use or proposed, oldest first");
}

}  // namespace infuse::daemon
