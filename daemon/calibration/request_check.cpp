#include "daemon/calibration/request_check.hpp"

namespace infuse::daemon {

std::optional<Error> check_request(const Request& request,
                                   const std::map<std::string, CalibrationReport>& calibrations) {
  const bool apply = request.op == Request::Op::kApply;
  if (!apply && request.op != Request::Op::kRollback) return std::nullopt;
  for (const auto& [camera, report] : calibrations) {
    if (!request.device.empty() && camera != request.device) continue;
    if (apply ? report.proposed : report.can_roll_back) return std::nullopt;
  }
  const std::string of = request.device.empty() ? "" : " of '" + request.device + "'";
  if (apply) {
    return Error{"no new calibration" + of + " waits to be applied", "",
                 "see infuse calibration; infuse recalibrate requests one"};
  }
  return Error{"there is no calibration" + of + " before the one in use", "",
               "see infuse calibration"};
}

}  // namespace infuse::daemon
