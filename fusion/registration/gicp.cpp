#include "fusion/registration/gicp.hpp"

namespace infuse::registration {

template class Registration<GicpFactor>;
template class Registration<PointToPlaneFactor>;

RegistrationResult gicp(const PreparedCloud& target, const PointCloud& source,
                        const Eigen::Isometry3d& T_target_source_guess,
                        const RegistrationOptions& options) {
  return Gicp(options).align(target, source, T_target_source_guess);
}

}  // namespace infuse::registration
