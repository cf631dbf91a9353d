#include "fusion/calibration/rejection_reason.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace infuse::calibration {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

constexpr int kMaxRestartsPerReturn = 2;  // one restart in so many must converge to the result
constexpr double kForeignSupport = 0.75;  // images of other places have less

template <class... Values>
std::string format_text(const char* format, Values... values) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

std::string check_text(const ParameterCheck& check) {
  if (check.gross && check.value == 0) {
    return "a fit of the intrinsics with the pose does not converge near the given ones; check the "
           "intrinsics";
  }
  const std::string by = check.value == 0 ? ""
                                          : format_text("%+.2g%s%s, ", check.value,
                                                        *check.unit == '\0' ? "" : " ", check.unit);
  return format_text("lidar and images would fit better with another %s (%s%.0f sigma)",
                     check.parameter.c_str(), by.c_str(), std::abs(check.significance));
}

/// What to do where only what the scenes show bounds the errors of the intrinsics, and they show
/// too little.
std::string unmeasured_text(const CalibrationResult& result, const CalibrateOptions& options) {
  if (options.known.intrinsics_stated) return {};
  Matrix6 stated = result.covariance();
  for (const ParameterCheck& check : result.parameter_checks) {
    const Vector6 moved = check.unseen_sigma * check.pose_sensitivity;
    stated -= moved * moved.transpose();
  }
  if (!describe_imprecision(stated, options.max_rotation_sigma, options.max_translation_sigma)
           .empty()) {
    return {};
  }
  return ": the intrinsics are unknown, and the scenes do not show them well enough";
}

}  // namespace

std::string rejection_reason(const CalibrationResult& result, const Maximum& maximum, double moved,
                             std::optional<double> delay, const CalibrateOptions& options) {
  if (!maximum.usable()) return maximum.reason;
  if (result.uncertainty.effective_scenes < kMinEffectiveScenes) return result.uncertainty.reason;
  const bool gross = std::any_of(result.parameter_checks.begin(), result.parameter_checks.end(),
                                 [](const ParameterCheck& check) { return check.gross; });
  if (delay && !gross && result.support >= kForeignSupport) {
    return format_text(
        "the result lies %.2f m from the initial position along the driving direction, as with "
        "another image time (%+.0f ms); check the stamps of the images",
        moved, 1e3 * *delay);
  }
  if (result.support < options.min_support && !gross) {
    return format_text(
        "the scenes do not support it: only %.0f %% of small wrong rotations make them fit worse "
        "(%.0f %% expected); check that images and sweeps belong together",
        100 * result.support, 100 * options.min_support);
  }
  for (const ParameterCheck& check : result.parameter_checks) {
    if (check.gross || check.serious) return check_text(check);
  }
  if (!result.best_of_restarts) {
    return "restarts from around the result kept finding larger values";
  }
  if (kMaxRestartsPerReturn * result.converged_restarts < result.restarts) {
    return format_text("only %d of %d restarts converged to the result", result.converged_restarts,
                       result.restarts);
  }
  if (!result.uncertainty.usable()) return result.uncertainty.reason;
  if (auto imprecise = describe_imprecision(result.covariance(), options.max_rotation_sigma,
                                            options.max_translation_sigma);
      !imprecise.empty()) {
    return imprecise + unmeasured_text(result, options);
  }
  if (moved > kMaxTranslationSigmas * options.initial_translation_sigma) {
    return format_text(
        "the result lies %.2f m from the initial position, whose standard deviation is %.2f m",
        moved, options.initial_translation_sigma);
  }
  return {};
}

}  // namespace infuse::calibration
