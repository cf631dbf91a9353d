#include "daemon/tools/calibrate/motion_uncertainty.hpp"

#include <spdlog/fmt/fmt.h>

#include <cmath>

namespace infuse::daemon {

MotionUncertainty motion_uncertainty(const ScenePairs& pairs,
                                     const Eigen::Isometry3d& T_refcam_lidar, bool refined_delay) {
  const geometry::Matrix6 adjoint = geometry::adjoint(T_refcam_lidar);
  geometry::Vector6 by_delay = geometry::Vector6::Zero(), by_blur = by_delay, largest = by_delay;
  size_t unknown = 0;
  for (const ScenePair& pair : pairs.pairs) {
    if (!pair.twist) {
      unknown += pair.deskew_reason.empty() ? 0 : 1;
      continue;
    }
    const geometry::Vector6 moves = adjoint * *pair.twist;
    if (!refined_delay) {
      by_delay += moves * to_seconds(pairs.cameras[pair.camera].stamp_delay_sigma);
    }
    by_blur += moves * to_seconds(pair.uncompensated) / std::sqrt(3.0);
    largest += moves * to_seconds(pair.uncompensated);
  }
  const double n = static_cast<double>(std::max<size_t>(pairs.pairs.size(), 1));
  MotionUncertainty result;
  result.covariance = (by_delay * by_delay.transpose() + by_blur * by_blur.transpose()) / (n * n);
  result.max_shift = largest.tail<3>().norm() / n;
  if (result.max_shift > kMaxUncompensatedShift) {
    result.reason = fmt::format(
        "the vehicle moves while sweeps that are not deskewed are measured: the result can be off "
        "by {:.0f} cm (speed times time); calibrate standing, or with odometry and times of the "
        "returns",
        100 * result.max_shift);
  }
  if (unknown > 0) {
    result.note = fmt::format(
        "the motion during {} of {} sweeps is neither known nor compensated: the result holds if "
        "the vehicle stood",
        unknown, pairs.pairs.size());
  }
  return result;
}

}  // namespace infuse::daemon
