#include "fusion/registration/refine.hpp"

namespace infuse::registration {

RegistrationResult refine(const PreparedCloud& target, const PointCloud& source,
                          const Eigen::Isometry3d& T_target_source_guess) {
  RegistrationOptions coarse;
  coarse.max_correspondence_distance = 2;
  coarse.steps.max_iterations = 15;
  const RegistrationResult rough = gicp(target, source, T_target_source_guess, coarse);
  return gicp(target, source, rough.T_target_source);
}

}  // namespace infuse::registration
