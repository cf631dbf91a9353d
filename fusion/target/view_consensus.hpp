#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "fusion/target/target_view.hpp"

namespace infuse::target {

/// The T_refcam_lidar that most views agree with, from planes alone: three views give one in closed
/// form (rotation between the normals by Arun's singular values, translation from the distances),
/// triples are drawn from the seed, and the one with the least median distance of a view's returns
/// from its board wins. Needs no start. Nothing where no triple has three independent normals.
std::optional<Eigen::Isometry3d> find_consensus_pose(std::span<const TargetView> views,
                                                     std::span<const ReturnsPlane> planes,
                                                     uint64_t seed);

/// Root mean square distance of a view's `points` from its board under a hypothesis, m.
double rms_board_distance(const TargetView& view, const ReturnsPlane& plane,
                          const Eigen::Isometry3d& T_refcam_lidar);

}  // namespace infuse::target
