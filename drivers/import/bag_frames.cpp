#include "drivers/import/bag_frames.hpp"

namespace infuse::importers {
namespace {

constexpr size_t kMaxBagFrames = 10'000;

bool is_finite(const ros::Transform& transform) {
  const auto& [t, q] = transform;
  const double norm = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
  return std::isfinite(t.x + t.y + t.z) && std::abs(norm - 1) < 0.01;
}

}  // namespace

std::string frame_name(const std::string& frame_id) {
  return frame_id.starts_with('/') ? frame_id.substr(1) : frame_id;
}

void FrameTree::add(const ros::TfMessage& message) {
  for (const ros::TransformStamped& transform : message.transforms) {
    const std::string child = frame_name(transform.child_frame_id);
    if (!is_finite(transform.transform)) continue;
    const Edge edge{frame_name(transform.header.frame_id), ros::to_isometry(transform.transform)};
    const auto known = edges_.find(child);
    if (known == edges_.end()) {
      if (edges_.size() < kMaxBagFrames) edges_.emplace(child, edge);
    } else if (known->second.parent != edge.parent ||
               !known->second.T_parent_child.isApprox(edge.T_parent_child, 1e-6)) {
      known->second.moves = true;
    }
  }
}

std::optional<FrameTree::Rooted> FrameTree::find_root(const std::string& frame) const {
  Rooted rooted{frame, Eigen::Isometry3d::Identity()};
  for (size_t steps = 0; steps <= edges_.size(); ++steps) {
    const auto edge = edges_.find(rooted.root);
    if (edge == edges_.end() || edge->second.moves) return rooted;
    rooted.T_root_frame = edge->second.T_parent_child * rooted.T_root_frame;
    rooted.root = edge->second.parent;
  }
  return std::nullopt;  // the transforms form a circle
}

std::optional<Eigen::Isometry3d> FrameTree::find(const std::string& target,
                                                 const std::string& source) const {
  if (target == source) return Eigen::Isometry3d::Identity();
  // The direct connection first: a path through the root would add rounding.
  const auto attached = [&](const std::string& child, const std::string& parent) -> const Edge* {
    const auto edge = edges_.find(child);
    const bool is = edge != edges_.end() && edge->second.parent == parent && !edge->second.moves;
    return is ? &edge->second : nullptr;
  };
  if (const Edge* edge = attached(source, target)) return edge->T_parent_child;
  if (const Edge* edge = attached(target, source)) return edge->T_parent_child.inverse();
  const auto a = find_root(target);
  const auto b = find_root(source);
  if (!a || !b || a->root != b->root) return std::nullopt;
  return a->T_root_frame.inverse() * b->T_root_frame;
}

std::string FrameTree::parent_of(const std::string& child) const {
  const auto edge = edges_.find(child);
  return edge == edges_.end() ? std::string() : edge->second.parent;
}

}  // namespace infuse::importers
