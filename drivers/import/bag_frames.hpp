#pragma once

#include <Eigen/Geometry>
#include <map>
#include <optional>
#include <string>

#include "drivers/ros/messages.hpp"

namespace infuse::importers {

/// The tree of frames of a recording, from its transforms.
class FrameTree {
 public:
  /// Adds the transforms of a message. A frame that moves (by more than 1 µm or 1 µrad between
  /// messages) connects nothing. Transforms that are not finite are ignored.
  void add(const ros::TfMessage& message);

  /// Returns T_target_source, or nothing if the frames are not connected rigidly.
  std::optional<Eigen::Isometry3d> find(const std::string& target, const std::string& source) const;

  /// The frame that `child` is attached to; empty if there is none.
  std::string parent_of(const std::string& child) const;

 private:
  struct Edge {
    std::string parent;
    Eigen::Isometry3d T_parent_child = Eigen::Isometry3d::Identity();
    bool moves = false;
  };
  /// A frame at the root of rigid connections, and the pose in it.
  struct Rooted {
    std::string root;
    Eigen::Isometry3d T_root_frame;
  };
  std::optional<Rooted> find_root(const std::string& frame) const;

  std::map<std::string, Edge> edges_;  ///< by the child
};

/// Returns the name of a frame without the slash that ROS 1 may put before it.
std::string frame_name(const std::string& frame_id);

}  // namespace infuse::importers
