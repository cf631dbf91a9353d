#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/health/alert.hpp"

namespace infuse::daemon {

/// Something that the daemon keeps on a disk.
struct StoreStatus {
  std::string name;                    ///< "state", "history", "calibrations", "recordings", "mqtt"
  std::optional<uint64_t> free_bytes;  ///< on its disk, for this user; nothing if not known
  std::string problem;                 ///< why it cannot be written; empty if it can
};

/// How the host's clock is kept, as the kernel knows it from chrony, ntpd or phc2sys.
struct SystemClock {
  bool synchronised = false;  ///< something keeps it
  double max_error_s = 0;     ///< bound of its error
  double error_s = 0;         ///< estimate of its error
};

/// What is known about the host at one tick; live only.
struct HostStatus {
  std::vector<StoreStatus> stores;
  std::optional<SystemClock> clock;  ///< nothing if it cannot be asked
};

/// The alerts about the host.
std::span<const Alert<HostStatus>> host_alerts();

}  // namespace infuse::daemon
