#pragma once

#include <optional>
#include <string>

#include "fusion/features/fpfh.hpp"
#include "fusion/registration/gicp.hpp"
#include "fusion/registration/rigid_consensus.hpp"
#include "fusion/registration/view_agreement.hpp"

namespace infuse::registration {

/// Settings of the global guess.
struct GlobalGuessOptions {
  double voxel_size = features::kFpfhGrid;            ///< m, grid of the points
  features::FpfhOptions fpfh;                         ///< of the features
  size_t max_keypoints = 3000;                        ///< of each scan, the most distinctive ones
  RigidConsensusOptions consensus{.hypotheses = 12};  ///< of the features
  double min_agreement =
      kMinPlaceAgreement;  ///< share of the points that a scan can judge and supports
  double min_lead = 0.2;   ///< by which every other pose's score is lower, as a share of the best
  double min_overlap = kMinPlaceOverlap;  ///< share of all points that are supported

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Finds the pose of one scan in another's frame without a guess: correspondences of FPFH features,
/// poses by consensus, each refined by GICP; the pose is taken that agrees best with what either
/// scan has seen of the other's points. Refused where that is not enough, or where another pose
/// agrees as well. Points in m, frame of their lidar. Deterministic.
RegistrationResult find_global_guess(const geometry::PointsView& target,
                                     const geometry::PointsView& source,
                                     const GlobalGuessOptions& options = {});

}  // namespace infuse::registration
