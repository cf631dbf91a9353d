#pragma once

#include "fusion/registration/gicp.hpp"

namespace infuse::registration {

/// Refines a pose that is right within a metre or two by GICP: with far counterparts first, then
/// with near ones. Not usable if GICP is not.
RegistrationResult refine(const PreparedCloud& target, const PointCloud& source,
                          const Eigen::Isometry3d& T_target_source_guess);

}  // namespace infuse::registration
