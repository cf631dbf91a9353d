#include "daemon/health/lidar_health.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

#include "drivers/measurement/ipv4_address.hpp"

namespace infuse::daemon {
namespace {

constexpr double kUnlimitedLoss = 2;  // above every fraction

std::string plural(uint64_t count, const char* noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

double lost_fraction(uint64_t lost, uint64_t received) {
  const uint64_t all = lost + received;
  return all == 0 ? 0 : static_cast<double>(lost) / static_cast<double>(all);
}

/// Growth of a counter; it may step back by a few when a late packet arrives after all.
uint64_t increase(uint64_t now, uint64_t before) { return now > before ? now - before : 0; }

}  // namespace

LidarHealth::LidarHealth(std::string endpoint, const HealthOptions& options, Stamp start)
    : endpoint_(std::move(endpoint)),
      options_(options),
      last_packet_(start),
      last_sweep_(start),
      previous_tick_(start),
      window_(start),
      // Silence has its own timeout: no further delay.
      conditions_{{"silent", Level::kStale, Duration::zero(), Duration::zero()},
                  {"unavailable", Level::kError, Duration::zero(), Duration::zero()},
                  {"undecodable", Level::kError, options.raise_after, options.clear_after},
                  {"two_sensors", Level::kError, options.raise_after, options.clear_after},
                  {"two_senders", Level::kError, options.raise_after, options.clear_after},
                  {"no_sweeps", Level::kError, Duration::zero(), options.clear_after},
                  {"heavy_loss", Level::kError, options.raise_after, options.clear_after},
                  {"loss", Level::kWarn, options.raise_after, options.clear_after},
                  {"wrong_sender", Level::kWarn, options.raise_after, options.clear_after},
                  {"sender_changed", Level::kWarn, Duration::zero(), options.clear_after},
                  {"wrong_model", Level::kWarn, options.raise_after, options.clear_after},
                  {"receive_buffer", Level::kWarn, options.raise_after, options.clear_after},
                  {"overload", Level::kWarn, options.raise_after, options.clear_after},
                  {"clock", Level::kWarn, options.raise_after, options.clear_after}} {}

const LidarStatus& LidarHealth::update(Stamp now, const LidarCounters& counters) {
  if (now < previous_tick_) restart_at(now);
  previous_tick_ = now;
  const Window::Snapshot oldest = window_.push(now, counters);
  const LidarCounters& before = oldest.counters;
  status_.counters = counters;
  measure_rates(now, oldest);

  conditions_.update({check_silence(now, counters), check_availability(counters.source),
                      check_decoding(counters, before), check_alternation(counters),
                      check_rival(counters), check_sweeps(now, counters),
                      check_loss(counters, before, options_.error_loss, kUnlimitedLoss),
                      check_loss(counters, before, options_.warn_loss, options_.error_loss),
                      check_sender(counters, before), check_sender_change(counters, before),
                      check_model(counters, before), check_receive_buffer(counters.source),
                      check_overload(counters, before), check_clock(now, counters)},
                     now);
  status_.findings = conditions_.findings();
  status_.transitions = conditions_.transitions();
  status_.level = conditions_.level();
  return status_;
}

// Drive time stepped back: older measurements are not comparable.
void LidarHealth::restart_at(Stamp now) {
  window_.restart_at(now, status_.counters);
  last_packet_ = last_sweep_ = now;
}

void LidarHealth::measure_rates(Stamp now, const Window::Snapshot& oldest) {
  const double seconds = to_seconds(now - oldest.stamp);
  const auto rate = [&](uint64_t at_now, uint64_t at_oldest) {
    return seconds > 0 ? static_cast<double>(increase(at_now, at_oldest)) / seconds : 0.0;
  };
  const LidarCounters& c = status_.counters;
  const LidarCounters& b = oldest.counters;
  status_.packets_hz = rate(c.packets, b.packets);
  status_.sweeps_hz = rate(c.sweeps, b.sweeps);
  status_.returns_hz = rate(c.returns, b.returns);
  status_.loss = lost_fraction(
      increase(c.lost_network, b.lost_network) + increase(c.lost_kernel, b.lost_kernel),
      increase(c.packets, b.packets));
}

CheckResult LidarHealth::check_silence(Stamp now, const LidarCounters& counters) {
  if (counters.packets != packets_seen_) last_packet_ = counters.last_packet;
  packets_seen_ = counters.packets;
  const Duration silence = now - last_packet_;
  if (silence < options_.stale_after) return {};
  std::string what = fmt::format("no data on {} for {:.1f} s", endpoint_, to_seconds(silence));
  if (counters.rejected() == 0) {
    return {true, std::move(what), "check the sensor's power, cable and destination address"};
  }
  what += fmt::format("; {} rejected, the last of {} bytes from {}",
                      plural(counters.rejected(), "datagram"), counters.unexpected_size,
                      address_text(counters.unexpected_sender));
  return {true, std::move(what), "check the configured sender, port and model"};
}

CheckResult LidarHealth::check_decoding(const LidarCounters& now,
                                        const LidarCounters& before) const {
  const uint64_t bad = increase(now.malformed, before.malformed);
  const uint64_t good = increase(now.packets, before.packets);
  if (bad == 0 || bad <= good) return {};
  return {
      true,
      fmt::format("{} on {} not decodable, the last of {} bytes from {}", plural(bad, "datagram"),
                  endpoint_, now.unexpected_size, address_text(now.unexpected_sender)),
      "check the configured model, and that nothing else sends to this port"};
}

CheckResult LidarHealth::check_alternation(const LidarCounters& now) const {
  if (!now.two_sensors) return {};
  return {true, fmt::format("packets of two sensors alternate on {}", endpoint_),
          "give the sensors different ports, or set the sender"};
}

CheckResult LidarHealth::check_rival(const LidarCounters& now) const {
  if (now.rival_sender == 0) return {};
  return {true,
          fmt::format("{} and {} both send as a sensor to {}; the first is used",
                      address_text(now.sender), address_text(now.rival_sender), endpoint_),
          "set the lidar's sender; find out what the other device is"};
}

CheckResult LidarHealth::check_sender_change(const LidarCounters& now,
                                             const LidarCounters& before) const {
  if (now.sender_changes == before.sender_changes) return {};
  return {true,
          fmt::format("the sender on {} changed from {} to {}", endpoint_,
                      address_text(now.previous_sender), address_text(now.sender)),
          "set the lidar's sender, unless the unit was exchanged"};
}

CheckResult LidarHealth::check_sweeps(Stamp now, const LidarCounters& counters) {
  if (counters.sweeps != sweeps_seen_ || counters.packets == 0) last_sweep_ = now;
  sweeps_seen_ = counters.sweeps;
  const Duration without = now - last_sweep_;
  if (without < options_.stale_after || now - last_packet_ >= options_.stale_after) return {};
  return {true,
          fmt::format("packets on {} but no complete sweep for {:.1f} s", endpoint_,
                      to_seconds(without)),
          "check that the sensor rotates"};
}

CheckResult LidarHealth::check_loss(const LidarCounters& now, const LidarCounters& before,
                                    double min_loss, double max_loss) const {
  const uint64_t network = increase(now.lost_network, before.lost_network);
  const uint64_t kernel = increase(now.lost_kernel, before.lost_kernel);
  const uint64_t received = increase(now.packets, before.packets);
  const double loss = lost_fraction(network + kernel, received);
  if (network + kernel == 0 || loss < min_loss || loss >= max_loss) return {};
  return {true,
          fmt::format("{:.2f} % packet loss ({} of {}: {} in the network, {} in the kernel)",
                      100 * loss, network + kernel, network + kernel + received, network, kernel),
          network >= kernel ? "check the cable, the switch and other traffic on the link"
                            : "raise net.core.rmem_max, or reduce the processor load"};
}

CheckResult LidarHealth::check_sender(const LidarCounters& now, const LidarCounters& before) const {
  const uint64_t unexpected = increase(now.wrong_sender, before.wrong_sender);
  // Two senders, and a changed one, are conditions of their own. Datagrams of a rival that is gone
  // are still within the window.
  const bool named = now.rival_sender != 0 || before.rival_sender != 0 ||
                     now.sender_changes != before.sender_changes;
  if (unexpected == 0 || named) return {};
  return {true,
          fmt::format("{} on {} from an unexpected sender ({})", plural(unexpected, "datagram"),
                      endpoint_, address_text(now.unexpected_sender)),
          "check the configured sender, or use another port for the other sensor"};
}

CheckResult LidarHealth::check_model(const LidarCounters& now, const LidarCounters& before) const {
  const uint64_t wrong = increase(now.wrong_model, before.wrong_model);
  if (wrong == 0) return {};
  return {true, fmt::format("{} on {} from another model", plural(wrong, "packet"), endpoint_),
          "check the configured model"};
}

CheckResult LidarHealth::check_overload(const LidarCounters& now,
                                        const LidarCounters& before) const {
  const uint64_t dropped = increase(now.dropped_sweeps, before.dropped_sweeps);
  if (dropped == 0) return {};
  return {true,
          fmt::format("{} not processed: the processor is too slow", plural(dropped, "sweep")),
          "see the latencies of the stages in HEALTH; reduce other load, the number of cameras, or "
          "set use_lidar = false in [odometry]"};
}

CheckResult LidarHealth::check_clock(Stamp now, const LidarCounters& counters) {
  if (counters.packets == 0) return {};
  if (!first_seen_) first_seen_ = now;
  if (counters.clock.trusted || now - *first_seen_ < options_.clock_grace) return {};
  return {true,
          fmt::format("device clock not trusted: {}",
                      *counters.clock.reason == '\0' ? "unknown reason" : counters.clock.reason),
          "connect a GNSS receiver with PPS to the sensor, and keep the host clock steady"};
}

}  // namespace infuse::daemon
