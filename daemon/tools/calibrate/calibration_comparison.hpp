#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "daemon/playback/calibration_scenes.hpp"
#include "daemon/protocol/json.hpp"
#include "fusion/calibration/compare_extrinsics.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::daemon {

/// An old and a new T_refcam_lidar, compared on scenes from which the new one was not estimated.
struct ComparedExtrinsics {
  Eigen::Isometry3d T_old = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_new = Eigen::Isometry3d::Identity();
  calibration::ExtrinsicComparison comparison;  ///< a: old, b: new
  /// Stated covariance of the new one; empty where it is unknown.
  std::optional<geometry::Matrix6> covariance = std::nullopt;

  /// T_new = exp(difference) T_old.
  geometry::Vector6 difference() const { return geometry::log(T_new * T_old.inverse()); }
  /// Squared Mahalanobis distance of the old one from the new one, by the new one's `covariance`.
  std::optional<double> mahalanobis_squared() const;

  /// "new", "old", or "neither" where a difference is as likely by chance.
  const char* better() const;
};

/// True for every second image of a camera, counted from 0: those that `hold_out` takes.
inline bool is_held_out(size_t of_camera) { return of_camera % 2 == 1; }

/// Takes every second image of each camera out of `pairs`, for the comparison.
ScenePairs hold_out(ScenePairs& pairs);

/// Compares on the scenes of the pairs that were held out. `covariance`: of T_new, if it is known.
ComparedExtrinsics compare_on(const ScenePairs& held_out,
                              std::span<const calibration::Scene> scenes,
                              const Eigen::Isometry3d& T_old, const Eigen::Isometry3d& T_new,
                              const std::optional<geometry::Matrix6>& covariance = std::nullopt);

Json to_json(const ComparedExtrinsics& compared);
std::string to_text(const ComparedExtrinsics& compared);

/// Writes a PNG image: of up to three of the pairs, the returns over the image with the old
/// extrinsics on the left and with the new ones on the right.
Result<void> write_overlays(const std::filesystem::path& file, const ScenePairs& held_out,
                            const ComparedExtrinsics& compared);

}  // namespace infuse::daemon
