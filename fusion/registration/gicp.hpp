#pragma once

#include "fusion/registration/registration.hpp"

namespace infuse::registration {

extern template class Registration<GicpFactor>;
extern template class Registration<PointToPlaneFactor>;

/// Generalized ICP, P 4.2.2 (Segal, Haehnel, Thrun 2009).
using Gicp = Registration<GicpFactor>;

/// The same, once.
RegistrationResult gicp(const PreparedCloud& target, const PointCloud& source,
                        const Eigen::Isometry3d& T_target_source_guess,
                        const RegistrationOptions& options = {});

}  // namespace infuse::registration
