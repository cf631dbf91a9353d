#pragma once

#include <string>

#include "daemon/protocol/json.hpp"

namespace infuse::daemon {

/// Makes the page of `infuse report`: HTML, style and code from daemon/pages/page, and `data`
/// (ReportData::to_json with what the command adds). It loads nothing: a Content-Security-Policy
/// forbids every address but data: images.
std::string make_report_page(const Json& data);

}  // namespace infuse::daemon
