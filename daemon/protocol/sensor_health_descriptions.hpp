#pragma once

#include "daemon/protocol/description_parts.hpp"
#include "drivers/measurement/ipv4_address.hpp"

namespace infuse::daemon {

// The sensors in HEALTH: lidars, cameras and vehicle sensors.

template <class Visitor>
void describe(Visitor& v, const ClockState& clock) {
  v.field("source", clock.source);
  v.field("trusted", clock.trusted, "True if the device's clock is trusted.",
          gauge("infuse_lidar_clock_trusted"));
  v.field("offset_ns", clock.offset.count(), "Host time minus device time.",
          gauge("infuse_lidar_clock_offset_seconds", 1e-9));
  v.field("jitter_ns", clock.jitter.count(), "Spread of the transport delay.",
          gauge("infuse_lidar_clock_jitter_seconds", 1e-9));
  v.field("skew_ppm", when(std::isfinite(clock.skew_ppm), rounded(clock.skew_ppm)),
          "Rate of the device's clock relative to the host's, minus one.",
          gauge("infuse_lidar_clock_skew_ratio", 1e-6));
  v.field("reason", when(!clock.trusted && *clock.reason != '\0', clock.reason),
          "why it is not trusted");
}

/// Datagrams lost or rejected, by cause.
struct PacketLosses {
  const LidarCounters& counters;
};

template <class Visitor>
void describe(Visitor& v, const PacketLosses& losses) {
  const auto cause = [&](const char* name, uint64_t count, const char* label, const char* text) {
    v.field(
        name, count, text,
        counter("infuse_lidar_packets_lost_total", label, "Packets lost or rejected, by cause."));
  };
  const LidarCounters& c = losses.counters;
  cause("network", c.lost_network, "cause=\"network\"", "missing by the device's counter");
  cause("kernel", c.lost_kernel, "cause=\"kernel\"", "dropped by the kernel, its buffer full");
  cause("malformed", c.malformed, "cause=\"malformed\"", "not packets of the sensor's model");
  cause("wrong_sender", c.wrong_sender, "cause=\"wrong_sender\"", "from another address");
  cause("duplicate", c.duplicates, "cause=\"duplicate\"", "repeated");
  cause("too_late", c.too_late, "cause=\"too_late\"", "too late to be used");
}

template <class Visitor>
void describe(Visitor& v, const DeviceHealth<LidarStatus>& sensor) {
  const LidarStatus& status = sensor.status;
  const LidarCounters& c = status.counters;
  v.field("device", sensor.device);
  v.field("level", status.level);
  v.field("packets_hz", non_negative(rounded(status.packets_hz)),
          "Packets per second over the last 10 s.", gauge("infuse_lidar_packets_hz"));
  v.field("sweeps_hz", non_negative(rounded(status.sweeps_hz)),
          "Sweeps per second over the last 10 s.", gauge("infuse_lidar_sweeps_hz"));
  v.field("returns_hz", non_negative(rounded(status.returns_hz)),
          "Returns per second over the last 10 s.", gauge("infuse_lidar_returns_hz"));
  v.field("packets", c.packets, "Data packets decoded since the start.",
          counter("infuse_lidar_packets_total"));
  v.field("position_packets", c.position_packets, "Position packets read since the start.",
          counter("infuse_lidar_position_packets_total"));
  v.field("sweeps", c.sweeps, "Sweeps completed since the start.",
          counter("infuse_lidar_sweeps_total"));
  v.field("dropped_sweeps", c.dropped_sweeps,
          "Sweeps that were not processed, because the processor was too slow; live only.",
          counter("infuse_lidar_dropped_sweeps_total"));
  v.field("returns", c.returns, "Returns in the completed sweeps.",
          counter("infuse_lidar_returns_total"));
  v.field("sender", when(c.sender != 0, address_text(c.sender)),
          "IPv4 address whose packets are used; absent before the first");
  v.field("rival_sender", when(c.rival_sender != 0, address_text(c.rival_sender)),
          "another address that sends as much as a sensor now");
  v.field(
      "sender_changes", c.sender_changes,
      "Number of times that another address was taken: the one before fell silent, or sent less "
      "than a sensor.",
      counter("infuse_lidar_sender_changes_total"));
  v.field("losses", PacketLosses{c}, "datagrams lost or rejected since the start, by cause");
  v.field("outages", c.outages,
          "Gaps of a whole turn and longer without packets; what they lack is counted as lost.",
          counter("infuse_lidar_outages_total"));
  v.field("out_of_order", c.out_of_order, "Packets that arrived late and were reordered.",
          counter("infuse_lidar_packets_out_of_order_total"));
  v.field("wrong_model", c.wrong_model, "Packets that are another model's than the configured one.",
          counter("infuse_lidar_packets_wrong_model_total"));
  v.field("stray_azimuths", c.stray_azimuths,
          "Azimuths that cannot be the sensor's, replaced by interpolation.",
          counter("infuse_lidar_stray_azimuths_total"));
  v.field("clock_jumps", c.clock_jumps, "Jumps of the device's counter.",
          counter("infuse_lidar_clock_jumps_total"));
  v.field("last_packet", when(c.packets > 0, c.last_packet),
          "Stamp of the last packet; absent before the first.",
          stamp_gauge("infuse_lidar_last_packet_timestamp_seconds"));
  v.field("stamp_source",
          when(*c.source.stamp_source != '\0', Choice<kStampSources>{c.source.stamp_source}),
          "live: who stamps its packets on arrival, the network interface or the kernel");
  v.field("clock", when(c.packets > 0, c.clock));
  v.field("findings", status.findings, "raised at present");
}

template <class Visitor>
void describe(Visitor& v, const DeviceHealth<StreamStatus>& stream) {
  const StreamCounters& c = stream.status.counters;
  v.field("device", stream.device);
  v.field("kind", Choice<kStreamKinds>{stream.kind});
  v.field("level", stream.status.level);
  v.field("received_hz", non_negative(rounded(stream.status.received_hz)),
          "Received per second over the last 10 s.", gauge("infuse_stream_received_hz"));
  v.field("received", c.received, "Images, frames, samples or fixes received.",
          counter("infuse_stream_received_total"));
  v.field("used", c.used, "Of these, passed to fusion.", counter("infuse_stream_used_total"));
  v.field("refused", c.refused, "Of these, not readable.", counter("infuse_stream_refused_total"));
  v.field("lost", c.lost, "Missing by their number, dropped by the kernel, or without a sweep.",
          counter("infuse_stream_lost_total"));
  v.field("out_of_order", c.out_of_order, "Stamps earlier than the one before.",
          counter("infuse_stream_out_of_order_total"));
  v.field("last", when(c.received > 0, c.last), "Stamp of the last; absent before the first.",
          stamp_gauge("infuse_stream_last_timestamp_seconds"));
  v.field("stamp_source",
          when(*c.source.stamp_source != '\0', Choice<kStampSources>{c.source.stamp_source}),
          "of a live CAN bus: stamps of its interface, or of the kernel");
  v.field("findings", stream.status.findings, "raised at present");
}

}  // namespace infuse::daemon
