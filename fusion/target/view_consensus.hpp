#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "fusion/target/target_view.hpp"

namespace infuse::target {

/// Estimates T_refcam_lidar by consensus of the planes: three views give a pose in closed form
/// (rotation between the normals by Arun's SVD, translation from the distances). Triples are drawn
/// at random from the seed; the pose with the smallest median distance of a view's returns from its
/// board wins. Needs no initial pose. Returns nullopt if no triple has three independent normals.
std::optional<Eigen::Isometry3d> find_consensus_pose(std::span<const TargetView> views,
                                                     std::span<const ReturnsPlane> planes,
                                                     uint64_t seed);

/// Root mean square distance of a view's `points` from its board for a given pose, m.
double rms_board_distance(const TargetView& view, const ReturnsPlane& plane,
                          const Eigen::Isometry3d& T_refcam_lidar);

}  // namespace infuse::target
