#include "daemon/server/last_values.hpp"

#include <algorithm>

namespace infuse::daemon {

void LastValues::set(ReportClass report_class, const std::string& device, Line line) {
  const auto at = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
    return entry.report_class == report_class && entry.device == device;
  });
  if (at == entries_.end()) {
    entries_.push_back({report_class, device, std::move(line)});
  } else {
    at->line = std::move(line);
  }
}

}  // namespace infuse::daemon
