#include "fusion/monitoring/drift_verdict.hpp"

#include "drivers/measurement/angles.hpp"
#include "fusion/monitoring/format_text.hpp"

namespace infuse::monitoring {
namespace {

std::string describe_offset(const DriftVerdict& verdict) {
  if (verdict.axis == Axis::kTime) {
    std::string text = format_text("stamps, %.0f ms late", 1e3 * verdict.delay);
    if (verdict.delay_ambiguous_axis) {
      text += format_text(" (or %s: not separable for this motion)",
                          name_of(*verdict.delay_ambiguous_axis));
    }
    return text;
  }
  const auto k = static_cast<Eigen::Index>(verdict.axis);
  const bool rotation = verdict.axis <= Axis::kRotationZ;
  const double factor = rotation ? 1 / kDegree : 100;
  std::string text =
      format_text("%s, by %+.2f ± %.2f %s", name_of(verdict.axis), verdict.offset(k) * factor,
                  verdict.sigma(k) * factor, rotation ? "°" : "cm");
  if (verdict.delay_ambiguous_axis == verdict.axis) {
    text += " (or late stamps: not separable for this motion)";
  }
  return text;
}

}  // namespace

void DriftVerdict::set_fault(CameraFault observed) {
  const bool late = drifting() && axis == Axis::kTime;
  fault = observed == CameraFault::kNone && late ? CameraFault::kLate : observed;
}

std::string describe_drift(const DriftVerdict& verdict) {
  return describe_offset(verdict) +
         format_text(" (evidence %.1f of %.1f nats)", verdict.evidence, verdict.threshold);
}

}  // namespace infuse::monitoring
