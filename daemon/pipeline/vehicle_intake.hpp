#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "daemon/health/stream_counters.hpp"
#include "daemon/pipeline/sensor_index.hpp"
#include "daemon/pipeline/vehicle_sample.hpp"
#include "daemon/pipeline/vehicle_setup.hpp"
#include "drivers/vehicle/candump.hpp"

namespace infuse::daemon {

/// The vehicle's own sensors: frames of its buses, samples and fixes in, samples for fusion out,
/// everything counted. Of the io thread.
class VehicleIntake {
 public:
  explicit VehicleIntake(const VehicleSetup& setup);

  /// Takes a line of the log of the first bus and calls `on_sample(VehicleSample)` for what it
  /// says.
  template <class OnSample>
  void add_can_line(std::string_view line, Stamp stamp, OnSample on_sample) {
    if (buses_.empty()) return;
    buses_[0].counters.count(stamp);
    if (const auto frame = read(line)) decode(buses_[0], *frame, on_sample);
  }

  /// The same with a frame as it came from a bus.
  template <class OnSample>
  void add_can_frame(BusIndex bus, const vehicle::CanFrame& frame, OnSample on_sample) {
    buses_[bus].counters.count(frame.stamp);
    if (!frame.error) decode(buses_[bus], frame, on_sample);
  }

  void count(const ImuSample& sample) { count(imu_, sample.stamp); }
  void count(const GnssFix& fix) { count(gnss_, fix.stamp); }

  /// What was wrong with the bus's log.
  const vehicle::ProblemLog& problems() const { return reader_.problems(); }

  /// Of all of them, in the order of PipelineSetup::devices, from `first` on.
  void write_counters(StreamCounters* first) const;

  /// How many counters that are.
  size_t stream_count() const { return buses_.size() + (has_imu_ ? 1 : 0) + (has_gnss_ ? 1 : 0); }

 private:
  struct Bus {
    std::optional<vehicle::VehicleDecoder> decoder;
    StreamCounters counters;
  };

  template <class OnSample>
  static void decode(Bus& bus, const vehicle::CanFrame& frame, OnSample on_sample) {
    if (!bus.decoder) return;
    const vehicle::VehicleSamples samples = bus.decoder->decode(frame);
    if (samples.wheels) on_sample(VehicleSample(*samples.wheels));
    if (samples.imu) on_sample(VehicleSample(*samples.imu));
    if (samples.wheels || samples.imu) ++bus.counters.used;
  }
  std::optional<vehicle::CanFrame> read(std::string_view line);
  static void count(StreamCounters& counters, Stamp stamp);

  vehicle::CandumpReader reader_{"can.log"};
  std::vector<Bus> buses_;
  bool has_imu_, has_gnss_;
  StreamCounters imu_, gnss_;
};

}  // namespace infuse::daemon
