#include "daemon/health/host_alerts.hpp"

#include <algorithm>

namespace infuse::daemon {
namespace {

constexpr Alert<HostStatus> kHostAlerts[] = {
    {{"state", Level::kWarn, Delays::kNone,
      "Something that the daemon keeps cannot be written: its state, the history, calibrations, "
      "the MCAP file, or reports for the broker, which wait in memory. Free space on the disk; "
      "`infuse status` says which it is."},
     [](const HostStatus& host) -> std::optional<Problem> {
       const auto failing = std::find_if(host.stores.begin(), host.stores.end(),
                                         [](const StoreStatus& s) { return !s.problem.empty(); });
       if (failing == host.stores.end()) return {};
       return Problem{failing->name + ": " + failing->problem,
                      "free space on its disk, or make it writable"};
     }},
    {{"system_clock", Level::kWarn, Delays::kBoth,
      "The host's clock is not synchronised: stamps of this vehicle do not agree with those of "
      "others. "
      "Install chrony, with rtcsync, or phc2sys."},
     [](const HostStatus& host) -> std::optional<Problem> {
       if (!host.clock || host.clock->synchronised) return {};
       return Problem{"the host's clock is not synchronised by NTP or PTP",
                      "install chrony, or phc2sys with a PTP clock; chronyc tracking says more"};
     }},
};

}  // namespace

std::span<const Alert<HostStatus>> host_alerts() { return kHostAlerts; }

}  // namespace infuse::daemon
