#include "daemon/health/stream_alerts.hpp"

#include <spdlog/fmt/fmt.h>

#include "daemon/health/source_checks.hpp"

namespace infuse::daemon {
namespace {

using StreamProblem = std::optional<Problem>;

constexpr Alert<StreamTick> kStreamAlerts[] = {
    {{"silent", Level::kStale, Delays::kNone,
      "No data for stale_after_s. Check power and connection; GNSS with bytes but no sentence: "
      "check baud, and that it sends RMC or GGA."},
     [](const StreamTick& tick) -> StreamProblem {
       if (tick.silence < tick.options.stale_after) return {};
       std::string what =
           fmt::format("no data from {} for {:.1f} s", tick.endpoint, to_seconds(tick.silence));
       const uint64_t unread = tick.now.source.unread_bytes;
       if (unread == 0) return Problem{std::move(what), "check power and connection"};
       what += fmt::format("; {} bytes without an RMC or GGA sentence", unread);
       return Problem{std::move(what),
                      "check baud in [gnss], and that the receiver sends RMC or GGA sentences"};
     }},
    {{"unavailable", Level::kError, Delays::kNone,
      "The device or interface cannot be opened; it is tried again. Connect it, or bring the "
      "interface up."},
     [](const StreamTick& tick) { return check_availability(tick.now.source); }},
    {{"bus_off", Level::kError, Delays::kNone,
      "CAN: the controller is bus-off. Check bit rate, cable and termination; restart it with `ip "
      "link set IF type can restart`, or set restart-ms."},
     [](const StreamTick& tick) { return check_bus_off(tick.now.source); }},
    {{"unreadable", Level::kError, Delays::kBoth,
      "Some of the data cannot be read. Check the data of the sensor or the recording."},
     [](const StreamTick& tick) -> StreamProblem {
       if (tick.refused() == 0) return {};
       return Problem{fmt::format("{} of {} from {} not readable", tick.refused(), tick.received(),
                                  tick.endpoint),
                      "check the data of the sensor or the recording"};
     }},
    {{"too_fast", Level::kError, Delays::kBoth,
      "More data than such a sensor sends. Find out what sends to the device."},
     [](const StreamTick& tick) -> StreamProblem {
       if (tick.received_hz <= tick.max_hz) return {};
       return Problem{fmt::format("{:.0f}/s from {}: no such sensor sends more than {:.0f}/s",
                                  tick.received_hz, tick.endpoint, tick.max_hz),
                      "find out what sends to this device"};
     }},
    {{"unused", Level::kError, Delays::kBoth,
      "Data arrives, but none of it is usable. Bus: check DBC file, interface and signal names."},
     [](const StreamTick& tick) -> StreamProblem {
       // A bus that carries frames, but none of the mapped signals.
       if (!tick.now.source.used || tick.received() == 0 || tick.now.used > tick.before.used ||
           tick.refused() >= tick.received()) {
         return {};
       }
       return Problem{fmt::format("no usable data from {}", tick.endpoint),
                      "check the DBC file, the interface and the signal names"};
     }},
    {{"loss", Level::kWarn, Delays::kBoth,
      "Images or frames are missing. Reduce the load of the processor or of the link."},
     [](const StreamTick& tick) -> StreamProblem {
       const uint64_t lost = tick.now.lost - tick.before.lost;
       if (lost == 0) return {};
       return Problem{
           fmt::format("{} of {} missing from {}", lost, lost + tick.received(), tick.endpoint),
           "reduce the load of the processor or of the link"};
     }},
    {{"bus_errors", Level::kWarn, Delays::kClearing,
      "CAN: the controller is error-warning or error-passive. Check bit rate, cable and "
      "termination."},
     [](const StreamTick& tick) { return check_bus_state(tick.now.source); }},
    {{"out_of_order", Level::kWarn, Delays::kClearing,
      "Stamps go back. Check the clock that stamps the data."},
     [](const StreamTick& tick) -> StreamProblem {
       const uint64_t out_of_order = tick.now.out_of_order - tick.before.out_of_order;
       if (out_of_order == 0) return {};
       return Problem{fmt::format("{} stamps of {} out of order", out_of_order, tick.endpoint),
                      "check the clock that stamps the data"};
     }},
};

}  // namespace

std::span<const Alert<StreamTick>> stream_alerts() { return kStreamAlerts; }

}  // namespace infuse::daemon
