#pragma once

#include <Eigen/Geometry>
#include <string>

#include "drivers/import/bag_import.hpp"
#include "drivers/measurement/rig.hpp"

namespace infuse::importers {

/// Intrinsics of a camera_info. Errors: a distortion that infuse does not have.
Result<CameraIntrinsics> intrinsics_of(const BagCamera& camera);

/// Mounting of a lidar by the transforms to `vehicle_frame`; without them the identity, and a note.
LidarMount mount_of(const BagLidar& lidar, const std::string& vehicle_frame,
                    BagImportSummary& summary);

/// Sets the lidar of a camera and the pose in it: of the lidar that the camera's frame is attached
/// to, else the first that is connected with it; without one the camera looks along the x of the
/// first lidar, and a note says so. There must be a lidar.
void relate_to_lidar(const BagCamera& camera, CameraMount& mount, BagImportSummary& summary);

/// Rotation from the frame of a topic's messages to the vehicle's; without a transform the
/// identity, and a note about `what`. `name`: the topic; empty: none.
Eigen::Matrix3d rotation_of(const std::string& name, const char* what,
                            const std::string& vehicle_frame, BagImportSummary& summary);

}  // namespace infuse::importers
