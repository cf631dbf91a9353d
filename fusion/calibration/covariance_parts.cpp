#include "fusion/calibration/covariance_parts.hpp"

#include <cmath>

namespace infuse::calibration {

std::vector<CovariancePart> covariance_parts(const CalibrationResult& result) {
  const Uncertainty& uncertainty = result.uncertainty;
  std::vector<CovariancePart> parts{
      {"the scatter of the scenes", uncertainty.covariance - uncertainty.bias_covariance},
      {"the bias of the measure", uncertainty.bias_covariance}};
  geometry::Matrix6 rest = result.model_covariance;
  for (const ParameterCheck& one : result.parameter_checks) {
    const geometry::Vector6 moved =
        std::hypot(one.known_sigma, one.unseen_sigma) * one.pose_sensitivity;
    parts.push_back({"the " + one.parameter, moved * moved.transpose()});
    rest -= parts.back().covariance;
  }
  parts.push_back({"the model", rest});
  return parts;
}

std::array<LargestPart, 6> largest_parts(std::span<const CovariancePart> parts) {
  std::array<LargestPart, 6> largest;
  for (Eigen::Index axis = 0; axis < 6; ++axis) {
    LargestPart& of = largest[static_cast<size_t>(axis)];
    double all = 0;
    for (const CovariancePart& part : parts) all += part.covariance(axis, axis);
    for (const CovariancePart& part : parts) {
      const double share = all > 0 ? part.covariance(axis, axis) / all : 0;
      if (share > of.share) of = {part.name, share};
    }
  }
  return largest;
}

}  // namespace infuse::calibration
