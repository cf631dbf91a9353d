#include "fusion/registration/registration_result.hpp"

#include <cmath>

namespace infuse::registration {

std::string RegistrationResult::free_directions_text() const {
  constexpr const char* kNames[6] = {"rotation about x",    "rotation about y",
                                     "rotation about z",    "translation along x",
                                     "translation along y", "translation along z"};
  std::string text;
  for (int i = 0; i < free_directions; ++i) {
    Eigen::Index axis = 0;
    free[static_cast<size_t>(i)].cwiseAbs().maxCoeff(&axis);
    if (text.find(kNames[axis]) != std::string::npos) continue;
    if (!text.empty()) text += ", ";
    text += kNames[axis];
  }
  return text;
}

}  // namespace infuse::registration
