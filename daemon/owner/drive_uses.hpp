#pragma once

#include <string>
#include <vector>

#include "daemon/command_line/summary.hpp"

namespace infuse::daemon {

/// Something that a drive can be used for, or what is missing for it.
struct DriveUse {
  const char* use = "";  ///< "deskewing", …
  bool possible = false;
  bool if_standing = false;  ///< not possible by the data, but if the vehicle stood still
  std::string statement;     ///< the share that is usable, and what is missing
};

/// Returns "yes", "no" or "only if the vehicle stood still".
const char* answer(const DriveUse& use);

/// Returns what a replayed drive can be used for: deskewing, monitoring and calibrating its
/// cameras, tracking on a street map. `has_map`: the drive names a map.
std::vector<DriveUse> drive_uses(const Summary& summary, bool has_map);

}  // namespace infuse::daemon
