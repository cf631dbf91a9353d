#pragma once

#include <string>

#include "daemon/protocol/json.hpp"
#include "daemon/tools/calibrate_intrinsics/board_images.hpp"
#include "fusion/target/calibrate_intrinsics.hpp"

namespace infuse::daemon {

/// The result as `infuse calibrate-intrinsics --json` prints it; the views are those of `images`.
Json to_json(const BoardImages& images, const target::IntrinsicsResult& result);

/// Standard deviations of a result as a rig states them.
IntrinsicsSigma stated_sigma(const target::IntrinsicsResult& result);

/// The result for people.
std::string to_text(const BoardImages& images, const target::IntrinsicsResult& result);

/// What of the image the result does not describe; empty if there are corners everywhere.
std::string describe_coverage(const target::IntrinsicsResult& result);

}  // namespace infuse::daemon
