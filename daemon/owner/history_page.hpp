#pragma once

#include <string>

#include "daemon/owner/history_entries.hpp"

namespace infuse::daemon {

/// Returns one HTML page, without network and code: the pose of each camera over the months, axis
/// by axis, the drift of each month, the alerts by id, and the time at each level of health.
std::string make_history_page(const HistoryEntries& entries);

}  // namespace infuse::daemon
