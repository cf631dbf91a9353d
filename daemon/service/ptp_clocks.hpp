#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "daemon/health/host_alerts.hpp"

namespace infuse::daemon {

/// Time of a PTP hardware clock minus the host's, s, by PTP_SYS_OFFSET_EXTENDED or PTP_SYS_OFFSET
/// (linux/ptp_clock.h): of several samples that of the least delay. Nothing where the device is
/// missing, is no such clock, or may not be read.
std::optional<double> ptp_offset(const std::filesystem::path& device);

/// The PTP hardware clocks of network interfaces, which ptp4l keeps, against the host's clock,
/// which phc2sys keeps.
class PtpClocks {
 public:
  using Ask = std::function<std::optional<double>(const std::filesystem::path& device)>;

  /// `folder` holds the devices ptp0, ptp1 …
  explicit PtpClocks(std::filesystem::path folder = "/dev", Ask ask = ptp_offset);

  /// The clocks that answer at present; a device that comes or goes is seen at the next call.
  std::vector<PtpClock> ask() const;

 private:
  std::filesystem::path folder_;
  Ask ask_;
};

}  // namespace infuse::daemon
