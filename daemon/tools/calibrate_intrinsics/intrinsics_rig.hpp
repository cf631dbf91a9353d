#pragma once

#include <filesystem>
#include <string>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/rig.hpp"

namespace infuse::daemon {

/// A rig with the intrinsics, and to what they are known, of its camera `name`, or of its only one
/// if `name` is empty. A camera that is not in the rig is added ("camera" without a name), looking
/// forward from the rig's first lidar; a rig without a lidar gets one. Errors: there are several
/// cameras, and no name.
Result<Rig> with_intrinsics(Rig rig, const std::string& name, const CameraIntrinsics& intrinsics,
                            const IntrinsicsSigma& sigma);

/// Writes `with_intrinsics` of the rig that the file holds, or of `rig` if there is no file.
/// Returns whether the camera was added to others.
Result<bool> write_intrinsics(const std::filesystem::path& path, const Rig& rig,
                              const std::string& name, const CameraIntrinsics& intrinsics,
                              const IntrinsicsSigma& sigma);

}  // namespace infuse::daemon
