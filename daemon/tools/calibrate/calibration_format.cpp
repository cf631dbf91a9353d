#include "daemon/tools/calibrate/calibration_format.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>

#include "daemon/protocol/number_json.hpp"
#include "drivers/measurement/angles.hpp"
#include "fusion/calibration/covariance_parts.hpp"
#include "fusion/geometry/extrinsic_error.hpp"

namespace infuse::daemon {
namespace {

// As `sigma_text` orders them.
constexpr std::array kSigmaAxes{"rx", "ry", "rz", "tx", "ty", "tz"};

Json error_json(const geometry::ExtrinsicError& error) {
  Json axes = Json::array();
  for (int k = 0; k < 6; ++k) axes.push_back(error.by_axis(k) * (k < 3 ? 1 / kDegree : 1.0));
  return {{"rotation_deg", error.rotation / kDegree},
          {"translation_m", error.translation},
          {"by_axis_deg_m", axes},
          {"pixels", error.pixels}};
}

Json scenes_json(const CalibrationRun& run, const ScenePairs& pairs) {
  Json list = Json::array();
  const calibration::CalibrationResult& result = run.result;
  for (size_t s = 0; s < pairs.pairs.size(); ++s) {
    const ScenePair& pair = pairs.pairs[s];
    Json scene = {{"name", pair.name},
                  {"stamp", pair.stamp.ns()},
                  {"gap_ms", rounded(1e3 * to_seconds(pair.gap))},
                  {"deskewed", pair.deskew_reason.empty()},
                  {"points", result.scenes[s].points},
                  {"value", result.scenes[s].value},
                  {"support", rounded(result.scenes[s].support)}};
    if (result.uncertainty.usable())
      scene["influence_sigma"] = rounded(result.uncertainty.scene_influence[s]);
    list.push_back(scene);
  }
  return list;
}

/// Checks of the assumed parameters against the scenes.
Json model_checks_json(const std::vector<calibration::ParameterCheck>& checks) {
  Json list = Json::array();
  for (const calibration::ParameterCheck& check : checks) {
    list.push_back({{"parameter", check.parameter},
                    {"error", check.value},
                    {"sigma", check.sigma},
                    {"unit", check.unit},
                    {"significance", rounded(check.significance)},
                    {"suspected", check.significant},
                    {"serious", check.serious}});
    if (check.detection_limit) list.back()["detection_limit"] = *check.detection_limit;
  }
  return list;
}

std::string model_check_text(const calibration::ParameterCheck& check) {
  const std::string by =
      check.sigma > 0 ? fmt::format(" ({:+.2f} {} +- {:.2f})", check.value, check.unit, check.sigma)
                      : "";
  return fmt::format("a different {}{} would fit better, {:.1f} sigma", check.parameter, by,
                     std::abs(check.significance));
}

/// Errors of the intrinsics that the scenes may not reveal, where they would shift the result by
/// more than its limits.
std::string undetected_errors_text(const CalibrationRun& run) {
  std::string text;
  for (const calibration::ParameterCheck& check : run.result.parameter_checks) {
    if (!check.detection_limit) continue;
    const double rotation = *check.detection_limit * check.pose_sensitivity.head<3>().norm();
    const double translation = *check.detection_limit * check.pose_sensitivity.tail<3>().norm();
    if (rotation < run.options.max_rotation_sigma &&
        translation < run.options.max_translation_sigma) {
      continue;
    }
    text += fmt::format("    {} by {:.2g}{}{}: {:.2f} deg, {:.1f} cm\n", check.parameter,
                        *check.detection_limit, *check.unit == '\0' ? "" : " ", check.unit,
                        rotation / kDegree, 100 * translation);
  }
  if (!text.empty()) {
    const calibration::KnownParameters& known = run.options.known;
    const std::string assumed =
        known.intrinsics_stated
            ? fmt::format(
                  "assume that the focal length is known to {:.2g} %, the principal point "
                  "to {:.2g} px, k1 to {:.2g}",
                  100 * known.focal_sigma, known.principal_point_sigma, known.radial_sigma)
            : "contain them: the intrinsics are unknown";
    text =
        "  errors of the intrinsics that the scenes may not reveal, and the shift they cause\n"
        "  (the standard deviations " +
        assumed + "):\n" + text;
  }
  const auto& estimates = run.result.intrinsics;
  if (!std::all_of(estimates.begin(), estimates.end(), [](const auto& one) { return one; })) {
    text +=
        "  errors of the intrinsics would not be revealed: that takes 8 scenes with enough points "
        "in view\n";
  }
  return text;
}

/// Standard deviations of a covariance's diagonal, in degrees and centimetres.
std::string sigma_text(const geometry::Matrix6& covariance) {
  const geometry::Vector6 sigma = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  return fmt::format("{:.3f} {:.3f} {:.3f} deg, {:.1f} {:.1f} {:.1f} cm", sigma(0) / kDegree,
                     sigma(1) / kDegree, sigma(2) / kDegree, 100 * sigma(3), 100 * sigma(4),
                     100 * sigma(5));
}

/// Refined intrinsics with their change.
Json refined_json(const calibration::RefinedIntrinsics& refined) {
  const CameraIntrinsics& camera = refined.intrinsics;
  const Eigen::Vector4d sigma = refined.covariance.diagonal().cwiseSqrt();
  const auto four = [](const Eigen::Vector4d& values) {
    return Json{{"focal_percent", 100 * values(0)},
                {"cx", values(1)},
                {"cy", values(2)},
                {"k1", values(3)}};
  };
  return {{"fx", camera.fx},
          {"fy", camera.fy},
          {"cx", camera.cx},
          {"cy", camera.cy},
          {"distortion", camera.distortion},
          {"change", four(refined.correction)},
          {"sigma", four(sigma)},
          // of the logarithm of the focal lengths, cx, cy, k1
          {"covariance", rows_json(refined.covariance)}};
}

std::string refined_text(const std::string& of, const calibration::RefinedIntrinsics& refined) {
  const CameraIntrinsics& camera = refined.intrinsics;
  const Eigen::Vector4d by = refined.correction;
  const Eigen::Vector4d sigma = refined.covariance.diagonal().cwiseSqrt();
  return fmt::format(
      "  intrinsics{}: fx {:.3f}, fy {:.3f}, cx {:.3f}, cy {:.3f}, k1 {:.5f}\n"
      "    changed by: f {:+.2f} % +- {:.2f}, cx {:+.2f} px +- {:.2f}, cy {:+.2f} px +- {:.2f}, "
      "k1 {:+.4f} +- {:.4f}\n",
      of, camera.fx, camera.fy, camera.cx, camera.cy, camera.distortion[0], 100 * by(0),
      100 * sigma(0), by(1), sigma(1), by(2), sigma(2), by(3), sigma(3));
}

std::string delay_text(const CalibrationRun& run, const ScenePairs& pairs) {
  return fmt::format("  stamp_delay_ms: {:.2f} +- {:.2f} (assumed: {:.2f})\n",
                     1e3 * *refined_delay(run, pairs), 1e3 * run.delay->sigma,
                     1e3 * to_seconds(pairs.cameras.front().stamp_delay));
}

std::string notes_text(const CalibrationRun& run, const ScenePairs& pairs) {
  std::string text = run.motion.note.empty() ? "" : "  note: " + run.motion.note + "\n";
  for (const std::string& note : pairs.notes) text += "  note: " + note + "\n";
  return text;
}

/// The pose, and what was estimated with it.
std::string pose_text(const CalibrationRun& run, const ScenePairs& pairs) {
  const calibration::CalibrationResult& result = run.result;
  const bool several = pairs.cameras.size() > 1;
  const auto moved =
      geometry::extrinsic_error(result.T_refcam_lidar, run.initial_pose, run.cameras.front().model);
  std::string text = fmt::format(
      "  {:.3f} deg, {:.1f} cm from the initial guess; dependence {:.5f} at the result, {:.5f} at "
      "the initial guess\n",
      moved.rotation / kDegree, 100 * moved.translation, result.value, result.initial_value);
  const Eigen::Matrix4d& T = result.T_refcam_lidar.matrix();
  text += fmt::format("  T_camera_lidar{} =\n", several ? " of " + pairs.cameras.front().name : "");
  for (int row = 0; row < 4; ++row) {
    text += fmt::format("    {:12.8f} {:12.8f} {:12.8f} {:12.6f}\n", T(row, 0), T(row, 1),
                        T(row, 2), T(row, 3));
  }
  for (size_t c = 0; run.refined && run.refined->refined && c < pairs.cameras.size(); ++c) {
    text += refined_text(several ? " of " + pairs.cameras[c].name : "", run.refined->cameras[c]);
  }
  if (refined_delay(run, pairs)) text += delay_text(run, pairs);
  return text;
}

/// The causes of the covariance, that of `motion_uncertainty` apart.
std::vector<calibration::CovariancePart> parts_of(const CalibrationRun& run) {
  calibration::CalibrationResult result = run.result;
  result.model_covariance -= run.motion.covariance;
  std::vector<calibration::CovariancePart> parts = calibration::covariance_parts(result);
  parts.push_back({"the vehicle's motion and uncertain times", run.motion.covariance});
  return parts;
}

/// "rx the principal point cy (71 %), …".
std::string largest_text(const CalibrationRun& run) {
  std::string text;
  const auto largest = calibration::largest_parts(parts_of(run));
  for (size_t axis = 0; axis < largest.size(); ++axis) {
    text += fmt::format("{}{} {} ({:.0f} %)", axis == 0 ? "" : ", ", kSigmaAxes[axis],
                        largest[axis].name, 100 * largest[axis].share);
  }
  return text;
}

/// The standard deviations and their parts.
std::string uncertainty_text(const CalibrationRun& run) {
  const calibration::CalibrationResult& result = run.result;
  const bool usable = result.uncertainty.usable();
  std::string text;
  if (usable) {
    text += "  standard deviation (rx ry rz, tx ty tz): " + sigma_text(result.covariance()) + "\n";
    text +=
        fmt::format("    from the scatter between scenes, which count as {:.1f}: {}\n",
                    result.uncertainty.effective_scenes,
                    sigma_text(result.uncertainty.covariance - result.uncertainty.bias_covariance));
    text += "    from the bias of the measure, which the scenes of a drive share: " +
            sigma_text(result.uncertainty.bias_covariance) + "\n";
    text += "    from intrinsics and times: " +
            sigma_text(result.model_covariance - run.motion.covariance) + "\n";
    text += "    of which from the vehicle's motion and uncertain times: " +
            sigma_text(run.motion.covariance) + "\n";
    text += "    mostly: " + largest_text(run) + "\n";
  }
  if (result.split_half) {
    text += "    for comparison, from the difference between two halves of the scenes: " +
            sigma_text(*result.split_half) + "\n";
  }
  if (usable) {
    text += "    Cramer-Rao bound: " + sigma_text(result.uncertainty.cramer_rao_bound) + "\n";
  }
  return text;
}

/// What supports the result, and what speaks against it.
std::string checks_text(const CalibrationRun& run, const ScenePairs& pairs) {
  const calibration::CalibrationResult& result = run.result;
  std::string text = fmt::format(
      "  {:.0f} % of test rotations by 1 and 2 deg fit worse than the result; {} of {} restarts "
      "converged\n",
      100 * result.support, result.converged_restarts, result.restarts);
  if (pairs.truth) {
    const auto error =
        geometry::extrinsic_error(result.T_refcam_lidar, *pairs.truth, run.cameras.front().model);
    text +=
        fmt::format("  error relative to the drive's truth: {:.3f} deg, {:.1f} cm, {:.1f} pixels\n",
                    error.rotation / kDegree, 100 * error.translation, error.pixels);
  }
  for (const calibration::ParameterCheck& check : result.parameter_checks) {
    if (check.significant) text += "  suspected: " + model_check_text(check) + "\n";
    if (check.unit == std::string("ms")) {
      text +=
          fmt::format("  image stamps 10 ms late would shift the result by {:.3f} deg, {:.1f} cm\n",
                      10 * check.pose_sensitivity.head<3>().norm() / kDegree,
                      10 * 100 * check.pose_sensitivity.tail<3>().norm());
    }
  }
  if (result.usable()) text += undetected_errors_text(run);
  return text;
}

void add_covariances(const CalibrationRun& run, Json& json) {
  const calibration::CalibrationResult& result = run.result;
  json["covariance"] = rows_json(result.covariance());
  json["covariance_of_scenes"] = rows_json(result.uncertainty.covariance);
  json["covariance_of_bias"] = rows_json(result.uncertainty.bias_covariance);
  const auto largest = calibration::largest_parts(parts_of(run));
  for (size_t axis = 0; axis < largest.size(); ++axis) {
    json["largest_uncertainty"][kSigmaAxes[axis]] = {{"cause", largest[axis].name},
                                                     {"share", rounded(largest[axis].share)}};
  }
  json["covariance_of_motion"] = rows_json(run.motion.covariance);
  json["cramer_rao_bound"] = rows_json(result.uncertainty.cramer_rao_bound);
}

}  // namespace

Json to_json(const CalibrationRun& run, const ScenePairs& pairs) {
  const calibration::CalibrationResult& result = run.result;
  const geometry::CameraModel& model = run.cameras.front().model;
  const auto moved = geometry::extrinsic_error(result.T_refcam_lidar, run.initial_pose, model);
  Json json = {{"camera", pairs.cameras.front().name},
               {"lidar", pairs.lidar},
               {"measure", run.measure},
               {"usable", result.usable()},
               {"reason", result.reason},
               {"initial_T_camera_lidar", by_row(run.initial_pose.matrix())},
               {"value", result.value},
               {"initial_value", result.initial_value},
               {"gain", result.value - result.initial_value},
               {"points", result.points},
               {"support", rounded(result.support)},
               {"effective_scenes", rounded(result.uncertainty.effective_scenes)},
               {"restarts", result.restarts},
               {"restarts_converged", result.converged_restarts},
               {"best_of_restarts", result.best_of_restarts},
               {"evaluations", result.evaluations},
               {"cpu_s", rounded(run.cpu_s)},
               {"scenes", scenes_json(run, pairs)},
               {"motion_max_shift_m", rounded(run.motion.max_shift)},
               {"notes", pairs.notes}};
  if (!run.motion.note.empty()) json["notes"].push_back(run.motion.note);
  if (result.has_pose) {
    json["T_camera_lidar"] = by_row(result.T_refcam_lidar.matrix());
    json["change_from_initial"] = error_json(moved);
  }
  if (result.uncertainty.usable()) add_covariances(run, json);
  for (size_t c = 0; result.has_pose && c < pairs.cameras.size() && pairs.cameras.size() > 1; ++c) {
    json["cameras"].push_back(
        {{"name", pairs.cameras[c].name},
         {"T_camera_lidar", by_row((T_camera_refcam(pairs, c) * result.T_refcam_lidar).matrix())}});
  }
  if (run.refined && run.refined->refined) {
    json["intrinsics"] = refined_json(run.refined->cameras.front());
    for (size_t c = 0; c < json.value("cameras", Json::array()).size(); ++c) {
      json["cameras"][c]["intrinsics"] = refined_json(run.refined->cameras[c]);
    }
  }
  if (const auto delay = refined_delay(run, pairs)) {
    json["stamp_delay_ms"] = rounded(1e3 * *delay);
    json["stamp_delay_sigma_ms"] = rounded(1e3 * run.delay->sigma);
  }
  if (!result.parameter_checks.empty())
    json["model_checks"] = model_checks_json(result.parameter_checks);
  if (result.split_half) json["split_half_covariance"] = rows_json(*result.split_half);
  if (pairs.truth && result.has_pose) {
    json["error"] =
        error_json(geometry::extrinsic_error(result.T_refcam_lidar, *pairs.truth, model));
  }
  return json;
}

std::string to_text(const CalibrationRun& run, const ScenePairs& pairs) {
  const calibration::CalibrationResult& result = run.result;
  const std::string heading = fmt::format(
      "{} against {}: {}, measure {}, {} scenes, {} points, {:.1f} s of CPU\n", camera_names(pairs),
      pairs.lidar, result.usable() ? "usable" : "NOT USABLE: " + result.reason, run.measure,
      run.scenes.size(), result.points, run.cpu_s);
  if (!result.has_pose) return heading + notes_text(run, pairs);
  return heading + pose_text(run, pairs) + uncertainty_text(run) + checks_text(run, pairs) +
         notes_text(run, pairs);
}

}  // namespace infuse::daemon
