#pragma once

#include <cstdint>

namespace infuse::monitoring {

/// Fault of a camera, apart from its pose.
enum class CameraFault : uint8_t {
  kNone,
  kBlack,       ///< the image is dark everywhere
  kFrozen,      ///< the same image repeats, byte for byte
  kDirty,       ///< a part of the image has lost its detail
  kOutOfFocus,  ///< fine detail is lost everywhere, coarse detail is not
  kLate,        ///< stamps are later than exposures, by `DriftVerdict::delay`
  kSwapped,     ///< the images are those of another camera, `DriftVerdict::images_of`
};

/// Returns "black", "frozen" …
const char* name_of(CameraFault fault);

}  // namespace infuse::monitoring
