#pragma once

#include <cmath>
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

/// A map that the daemon uses.
struct MapInUse {
  std::string name;     ///< "streetmap", "map"
  std::string digest;   ///< of its bytes
  std::string problem;  ///< why what lies in its place is not used; empty if it is this one
};

/// How the host's clock is kept, as the kernel knows it from chrony, ntpd or phc2sys.
struct SystemClock {
  bool synchronised = false;  ///< something keeps it
  double max_error_s = 0;     ///< bound of its error
  double error_s = 0;         ///< estimate of its error
};

/// A PTP hardware clock of a network interface.
struct PtpClock {
  std::string device;  ///< "ptp0"
  double offset_s =
      0;  ///< of its time to the host's; where it counts TAI, without the whole seconds

  /// The host follows it, or it the host. The limit is what a sensor's stamps are trusted to.
  bool agrees() const { return std::abs(offset_s) < 1e-3; }
};

/// What is known about the host at one tick; live only.
struct HostStatus {
  std::vector<StoreStatus> stores;
  std::optional<SystemClock> clock;  ///< nothing if it cannot be asked
  std::vector<MapInUse> maps;
  std::vector<PtpClock> ptp_clocks;  ///< that may be read
  bool ptp_sensors = false;          ///< the clock of a sensor follows PTP
};

/// The alerts about the host.
std::span<const Alert<HostStatus>> host_alerts();

}  // namespace infuse::daemon
