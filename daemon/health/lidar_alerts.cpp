#include "daemon/health/lidar_alerts.hpp"

#include <spdlog/fmt/fmt.h>

#include "daemon/health/counting.hpp"
#include "daemon/health/source_checks.hpp"
#include "drivers/measurement/ipv4_address.hpp"

namespace infuse::daemon {
namespace {

using LidarProblem = std::optional<Problem>;

/// Spinning lidars turn 20 times a second at most (references.md, the makers' manuals); half as
/// much again for parts of turns.
constexpr double kMaxSweepsHz = 30;

std::string plural(uint64_t count, const char* noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

/// The fraction of lost packets over the window, if it is one of `min_loss` … `max_loss`.
LidarProblem check_loss(const LidarTick& tick, double min_loss, double max_loss) {
  const uint64_t network = increase(tick.now.lost_network, tick.before.lost_network);
  const uint64_t kernel = increase(tick.now.lost_kernel, tick.before.lost_kernel);
  const uint64_t received = increase(tick.now.packets, tick.before.packets);
  const double loss = lost_fraction(network + kernel, received);
  if (network + kernel == 0 || loss < min_loss || loss >= max_loss) return {};
  return Problem{
      fmt::format("{:.2f} % packet loss ({} of {}: {} in the network, {} in the kernel)",
                  100 * loss, network + kernel, network + kernel + received, network, kernel),
      network >= kernel ? "check the cable, the switch and other traffic on the link"
                        : "raise net.core.rmem_max, or reduce the processor load"};
}

constexpr Alert<LidarTick> kLidarAlerts[] = {
    {{"silent", Level::kStale, Delays::kNone,
      "No data for stale_after_s. Check power, cable and destination address; if datagrams were "
      "rejected, sender, port and model."},
     [](const LidarTick& tick) -> LidarProblem {
       if (tick.silence < tick.options.stale_after) return {};
       std::string what =
           fmt::format("no data on {} for {:.1f} s", tick.endpoint, to_seconds(tick.silence));
       if (tick.now.rejected() == 0) {
         return Problem{std::move(what), "check the sensor's power, cable and destination address"};
       }
       what += fmt::format("; {} rejected, the last of {} bytes from {}",
                           plural(tick.now.rejected(), "datagram"), tick.now.unexpected_size,
                           address_text(tick.now.unexpected_sender));
       return Problem{std::move(what), "check the configured sender, port and model"};
     }},
    {{"unavailable", Level::kError, Delays::kNone,
      "Its socket or interface cannot be opened; it is tried again. Bring the interface up."},
     [](const LidarTick& tick) { return check_availability(tick.now.source); }},
    {{"undecodable", Level::kError, Delays::kBoth,
      "Most datagrams are not packets of the model. Check model, and that nothing else sends to "
      "the port."},
     [](const LidarTick& tick) -> LidarProblem {
       const uint64_t bad = increase(tick.now.malformed, tick.before.malformed);
       const uint64_t good = increase(tick.now.packets, tick.before.packets);
       if (bad == 0 || bad <= good) return {};
       return Problem{fmt::format("{} on {} not decodable, the last of {} bytes from {}",
                                  plural(bad, "datagram"), tick.endpoint, tick.now.unexpected_size,
                                  address_text(tick.now.unexpected_sender)),
                      "check the configured model, and that nothing else sends to this port"};
     }},
    {{"two_sensors", Level::kError, Delays::kBoth,
      "Packets of two sensors alternate on the port. Give them different ports, or set sender."},
     [](const LidarTick& tick) -> LidarProblem {
       if (!tick.now.two_sensors) return {};
       return Problem{fmt::format("packets of two sensors alternate on {}", tick.endpoint),
                      "give the sensors different ports, or set the sender"};
     }},
    {{"two_senders", Level::kError, Delays::kBoth,
      "A second address sends as much as a sensor; the first is used. Set sender, and find out "
      "what the other device is."},
     [](const LidarTick& tick) -> LidarProblem {
       if (tick.now.rival_sender == 0) return {};
       return Problem{fmt::format("{} and {} both send as a sensor to {}; the first is used",
                                  address_text(tick.now.sender),
                                  address_text(tick.now.rival_sender), tick.endpoint),
                      "set the lidar's sender; find out what the other device is"};
     }},
    {{"no_sweeps", Level::kError, Delays::kClearing,
      "Packets, but no complete sweep for stale_after_s. Check that the sensor rotates."},
     [](const LidarTick& tick) -> LidarProblem {
       const Duration limit = tick.options.stale_after;
       if (tick.without_sweep < limit || tick.silence >= limit) return {};
       return Problem{fmt::format("packets on {} but no complete sweep for {:.1f} s", tick.endpoint,
                                  to_seconds(tick.without_sweep)),
                      "check that the sensor rotates"};
     }},
    {{"too_fast", Level::kError, Delays::kBoth,
      "More sweeps than a lidar can turn: packets are damaged, forged, or of several sensors. Set "
      "sender, and find out what else sends to the port."},
     [](const LidarTick& tick) -> LidarProblem {
       if (tick.sweeps_hz <= kMaxSweepsHz) return {};
       return Problem{fmt::format("{:.0f} sweeps/s on {}: no lidar turns so fast", tick.sweeps_hz,
                                  tick.endpoint),
                      "set the lidar's sender; find out what else sends to this port"};
     }},
    {{"heavy_loss", Level::kError, Delays::kBoth,
      "More than error_loss of the packets is lost. In the network: check cable, switch and other "
      "traffic. In the kernel: raise net.core.rmem_max, or reduce the processor load."},
     [](const LidarTick& tick) {
       constexpr double kUnlimited = 2;  // above every fraction
       return check_loss(tick, tick.options.error_loss, kUnlimited);
     }},
    {{"loss", Level::kWarn, Delays::kBoth,
      "More than warn_loss of the packets is lost, and less than error_loss. Remedies as for "
      "heavy_loss."},
     [](const LidarTick& tick) {
       return check_loss(tick, tick.options.warn_loss, tick.options.error_loss);
     }},
    {{"wrong_sender", Level::kWarn, Delays::kBoth,
      "Datagrams come from another address. Check sender, or use another port for the other "
      "sensor."},
     [](const LidarTick& tick) -> LidarProblem {
       const uint64_t unexpected = increase(tick.now.wrong_sender, tick.before.wrong_sender);
       // Two senders, and a changed one, are alerts of their own. Datagrams of a rival that is gone
       // are still within the window.
       const bool named = tick.now.rival_sender != 0 || tick.before.rival_sender != 0 ||
                          tick.now.sender_changes != tick.before.sender_changes;
       if (unexpected == 0 || named) return {};
       return Problem{
           fmt::format("{} on {} from an unexpected sender ({})", plural(unexpected, "datagram"),
                       tick.endpoint, address_text(tick.now.unexpected_sender)),
           "check the configured sender, or use another port for the other sensor"};
     }},
    {{"sender_changed", Level::kWarn, Delays::kClearing,
      "Another address sends now. Set sender, unless the unit was exchanged."},
     [](const LidarTick& tick) -> LidarProblem {
       if (tick.now.sender_changes == tick.before.sender_changes) return {};
       return Problem{
           fmt::format("the sender on {} changed from {} to {}", tick.endpoint,
                       address_text(tick.now.previous_sender), address_text(tick.now.sender)),
           "set the lidar's sender, unless the unit was exchanged"};
     }},
    {{"wrong_model", Level::kWarn, Delays::kBoth, "Packets of another model. Check model."},
     [](const LidarTick& tick) -> LidarProblem {
       const uint64_t wrong = increase(tick.now.wrong_model, tick.before.wrong_model);
       if (wrong == 0) return {};
       return Problem{
           fmt::format("{} on {} from another model", plural(wrong, "packet"), tick.endpoint),
           "check the configured model"};
     }},
    {{"receive_buffer", Level::kWarn, Delays::kBoth,
      "The kernel granted less than receive_buffer_bytes. Raise net.core.rmem_max."},
     [](const LidarTick& tick) { return check_receive_buffer(tick.now.source); }},
    {{"overload", Level::kWarn, Delays::kBoth,
      "Sweeps were not processed: the processor is too slow. See the latencies in HEALTH; reduce "
      "other load or the number of cameras, or set use_lidar = false."},
     [](const LidarTick& tick) -> LidarProblem {
       const uint64_t dropped = increase(tick.now.dropped_sweeps, tick.before.dropped_sweeps);
       if (dropped == 0) return {};
       return Problem{
           fmt::format("{} not processed: the processor is too slow", plural(dropped, "sweep")),
           "see the latencies of the stages in HEALTH; reduce other load, the number of cameras, "
           "or set use_lidar = false in [odometry]"};
     }},
    {{"clock", Level::kWarn, Delays::kBoth,
      "The device's clock is not trusted after clock_grace_s. Connect a GNSS receiver with PPS to "
      "the sensor; keep the host clock steady."},
     [](const LidarTick& tick) -> LidarProblem {
       const ClockState& clock = tick.now.clock;
       if (!tick.since_first || clock.trusted || *tick.since_first < tick.options.clock_grace) {
         return {};
       }
       return Problem{
           fmt::format("device clock not trusted: {}",
                       *clock.reason == '\0' ? "unknown reason" : clock.reason),
           "connect a GNSS receiver with PPS to the sensor, and keep the host clock steady"};
     }},
};

}  // namespace

std::span<const Alert<LidarTick>> lidar_alerts() { return kLidarAlerts; }

}  // namespace infuse::daemon
