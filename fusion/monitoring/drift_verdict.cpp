#include "fusion/monitoring/drift_verdict.hpp"

#include <cmath>

#include "drivers/measurement/angles.hpp"
#include "fusion/monitoring/format_text.hpp"

namespace infuse::monitoring {
namespace {

/// What an offset along an axis is stated in: its unit, and how many of them are in a rad or m.
struct OffsetUnit {
  double per_unit;
  const char* name;
};

OffsetUnit unit_of(Axis axis) {
  return axis <= Axis::kRotationZ ? OffsetUnit{1 / kDegree, "°"} : OffsetUnit{100, " cm"};
}

std::string describe_most_likely(const DriftVerdict& verdict) {
  if (verdict.axis == Axis::kTime) {
    std::string text = format_text("stamps %.0f ms late", 1e3 * verdict.delay);
    if (verdict.delay_ambiguous_axis) {
      text += format_text(" (or %s: this motion does not separate them)",
                          name_of(*verdict.delay_ambiguous_axis));
    }
    return text;
  }
  const auto k = static_cast<Eigen::Index>(verdict.axis);
  const OffsetUnit unit = unit_of(verdict.axis);
  std::string text = verdict.at_least
                         ? format_text("%s by at least %+.1f%s", name_of(verdict.axis),
                                       verdict.offset(k) * unit.per_unit, unit.name)
                         : describe_offset(verdict.axis, verdict.offset(k), verdict.sigma(k));
  if (verdict.delay_ambiguous_axis == verdict.axis) {
    text += " (or late stamps: this motion does not separate them)";
  }
  return text;
}

}  // namespace

void DriftVerdict::set_fault(CameraFault observed, const std::string& other) {
  const bool late = drift == Drift::kConfirmed && axis == Axis::kTime;
  const bool swapped = observed == CameraFault::kNone && !other.empty();
  fault = swapped                                  ? CameraFault::kSwapped
          : observed == CameraFault::kNone && late ? CameraFault::kLate
                                                   : observed;
  images_of = swapped ? other : "";
}

std::string describe_fault(const DriftVerdict& verdict) {
  std::string text = name_of(verdict.fault);
  if (verdict.fault == CameraFault::kSwapped) {
    text += ": its images are those of the camera " + verdict.images_of;
  }
  if (verdict.fault == CameraFault::kLate) text += ": " + describe_drift(verdict);
  return text;
}

std::string describe_offset(Axis axis, double offset, double sigma) {
  const OffsetUnit unit = unit_of(axis);
  return format_text("%s by %+.2f ± %.2f%s", name_of(axis), offset * unit.per_unit,
                     sigma * unit.per_unit, unit.name);
}

std::string describe_drift(const DriftVerdict& verdict) {
  // Odds of 20 : 1 decide: one in twenty is wrong.
  constexpr double kDecided = 3;  // nats
  const double odds = verdict.evidence - verdict.runner_up_evidence;
  std::string other;
  if (verdict.runner_up_evidence > 0 && odds < kDecided && verdict.runner_up != verdict.axis) {
    other = format_text(", or %s (odds %.0f : 1)", name_of(verdict.runner_up), std::exp(odds));
  }
  return describe_most_likely(verdict) + other +
         format_text(" (evidence %.1f, threshold %.1f nats)", verdict.evidence, verdict.threshold);
}

}  // namespace infuse::monitoring
