#include "daemon/health/host_alerts.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <functional>

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
    {{"new_map", Level::kWarn, Delays::kNone,
      "What lies in the place of a map in use is not used: it is damaged, incomplete or of another "
      "place. The map in use stays. Put a whole map there; the daemon takes it over by itself."},
     [](const HostStatus& host) -> std::optional<Problem> {
       const auto refused = std::find_if(host.maps.begin(), host.maps.end(),
                                         [](const MapInUse& m) { return !m.problem.empty(); });
       if (refused == host.maps.end()) return {};
       return Problem{"the new " + refused->name + " is not used: " + refused->problem,
                      "put a whole map there; the one in use stays until then"};
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
    {{"ptp_clock", Level::kWarn, Delays::kBoth,
      "A sensor's clock follows PTP, and no PTP clock of this host agrees with the host's clock "
      "within 1 ms: PTP does not bring the sensor's stamps into the host's time. Run ptp4l and "
      "phc2sys on the sensor's interface."},
     [](const HostStatus& host) -> std::optional<Problem> {
       const auto& clocks = host.ptp_clocks;
       if (!host.ptp_sensors || clocks.empty() ||
           std::any_of(clocks.begin(), clocks.end(), std::mem_fn(&PtpClock::agrees))) {
         return {};
       }
       const auto nearest =
           std::min_element(clocks.begin(), clocks.end(), [](const auto& a, const auto& b) {
             return std::abs(a.offset_s) < std::abs(b.offset_s);
           });
       return Problem{
           fmt::format("a sensor's clock follows PTP, and the host's clock is {:.3g} s off "
                       "the PTP clock {}",
                       std::abs(nearest->offset_s), nearest->device),
           "run ptp4l and phc2sys on the sensor's interface"};
     }},
};

}  // namespace

std::span<const Alert<HostStatus>> host_alerts() { return kHostAlerts; }

}  // namespace infuse::daemon
