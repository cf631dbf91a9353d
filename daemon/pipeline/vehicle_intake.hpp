#pragma once

#include <algorithm>
#include <optional>
#include <string_view>
#include <vector>

#include "daemon/health/stream_counters.hpp"
#include "daemon/pipeline/vehicle_sample.hpp"
#include "daemon/setup/sensor_table.hpp"
#include "drivers/vehicle/candump.hpp"

namespace infuse::daemon {

/// The vehicle's own sensors: CAN frames, speeds, IMU samples and GNSS fixes in, samples for fusion
/// out, everything counted. Used by the io thread.
class VehicleIntake {
 public:
  explicit VehicleIntake(const VehicleSetup& setup);

  /// Processes a line of the first bus's log and calls `on_sample(VehicleSample)` for its samples.
  template <class OnSample>
  void add_can_line(std::string_view line, Stamp stamp, OnSample on_sample) {
    if (buses_.empty()) return;
    buses_[0].counters.count(stamp);
    if (const auto frame = read(line)) decode(buses_[0], *frame, on_sample);
  }

  /// Processes a frame of a bus in the same way.
  template <class OnSample>
  void add_can_frame(BusIndex bus, const vehicle::CanFrame& frame, OnSample on_sample) {
    buses_[bus].counters.count(frame.stamp);
    if (!frame.error) decode(buses_[bus], frame, on_sample);
  }

  void count(const WheelOdometry& speed) { count(speed_, speed.stamp); }
  void count(const ImuSample& sample) { count(imu_, sample.stamp); }
  void count(const GnssFix& fix) { count(gnss_, fix.stamp); }

  /// True if the vehicle has an inertial unit of its own, so that a lidar's is not used: by the
  /// set-up, or by what a bus has delivered.
  bool has_inertial_unit() const {
    return has_imu_ || std::any_of(buses_.begin(), buses_.end(),
                                   [](const Bus& bus) { return bus.has_inertial_unit; });
  }

  /// Problems of the CAN log.
  const vehicle::ProblemLog& problems() const { return reader_.problems(); }

  /// Writes the counters of the vehicle's sensors.
  void write_counters(SensorCounters& counters) const;

 private:
  struct Bus {
    std::optional<vehicle::VehicleDecoder> decoder;
    StreamCounters counters;
    bool has_inertial_unit = false;
  };

  template <class OnSample>
  static void decode(Bus& bus, const vehicle::CanFrame& frame, OnSample on_sample) {
    if (!bus.decoder) return;
    const vehicle::VehicleSamples samples = bus.decoder->decode(frame);
    if (samples.wheels) on_sample(VehicleSample(*samples.wheels));
    if (samples.imu) on_sample(VehicleSample(*samples.imu));
    bus.has_inertial_unit |= samples.imu.has_value();
    if (samples.wheels || samples.imu) ++bus.counters.used;
  }
  std::optional<vehicle::CanFrame> read(std::string_view line);
  static void count(StreamCounters& counters, Stamp stamp);

  bool has_imu_;  // of its own
  vehicle::CandumpReader reader_{"can.log"};
  std::vector<Bus> buses_;
  StreamCounters speed_, imu_, gnss_;
};

}  // namespace infuse::daemon
