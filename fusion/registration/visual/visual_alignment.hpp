#pragma once

#include <optional>
#include <string>

#include "fusion/registration/gicp.hpp"
#include "fusion/registration/rigid_consensus.hpp"
#include "fusion/registration/visual/camera_consensus.hpp"
#include "fusion/registration/visual/sift_returns.hpp"

namespace infuse::registration {

/// Settings of the visually bootstrapped GICP.
struct VisualAlignmentOptions {
  double keypoint_radius = 2;  ///< pixels, from a keypoint to the return that gives its place
  double max_ratio = 0.85;     ///< of the distances to the nearest and the second nearest
                               ///< descriptor, for a match (Lowe 2004)
  RigidConsensusOptions consensus{.inlier_distance = 0.4, .min_side = 1, .min_share = 0.03};
  double min_agreement = 0.7;  ///< share of the points that a scan can judge and supports

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// An alignment by image features, before and after GICP.
struct VisualAlignment {
  RegistrationResult result;  ///< of GICP
  ConsensusMatrix measured;   ///< P(4.2)
  ConsensusMatrix consensus;  ///< its ideal counterpart
  size_t matches = 0;         ///< that the consensus allows
  RigidConsensus bootstrap;   ///< the pose before GICP, and its inliers
};

/// Aligns two sweeps with images without a guess (VB-GICP, P 4.2, algorithm 2): keypoints that have
/// a return are matched between the cameras that the consensus matrix allows, three-point RANSAC
/// gives a pose, GICP refines it. Both scans are of one rig: image k of both is of the same camera.
/// `options.invalid()` must be empty. Deterministic. Errors: as `find_sift_returns`, and scans
/// with different numbers of images.
Result<VisualAlignment> align_by_keypoints(const CameraLidarScan& target,
                                           const CameraLidarScan& source,
                                           const VisualAlignmentOptions& options = {});

}  // namespace infuse::registration
