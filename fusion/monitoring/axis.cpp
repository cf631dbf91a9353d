#include "fusion/monitoring/axis.hpp"

#include <array>

namespace infuse::monitoring {

const char* name_of(Axis axis) {
  constexpr std::array<const char*, 7> kNames = {"rotation about x",
                                                 "rotation about y",
                                                 "rotation about z",
                                                 "translation along x",
                                                 "translation along y",
                                                 "translation along z",
                                                 "time"};
  return kNames[static_cast<size_t>(base_axis(axis))];
}

}  // namespace infuse::monitoring
