#include "fusion/monitoring/camera_fault.hpp"

namespace infuse::monitoring {

const char* name_of(CameraFault fault) {
  switch (fault) {
    case CameraFault::kNone:
      return "none";
    case CameraFault::kBlack:
      return "black";
    case CameraFault::kFrozen:
      return "frozen";
    case CameraFault::kDirty:
      return "dirty";
    case CameraFault::kOutOfFocus:
      return "out of focus";
    case CameraFault::kLate:
      return "late";
    case CameraFault::kSwapped:
      return "swapped";
  }
  return "";
}

}  // namespace infuse::monitoring
