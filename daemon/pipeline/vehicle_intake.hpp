#pragma once

#include <optional>
#include <string_view>

#include "daemon/health/stream_counters.hpp"
#include "daemon/pipeline/vehicle_sample.hpp"
#include "daemon/pipeline/vehicle_setup.hpp"
#include "drivers/vehicle/candump.hpp"

namespace infuse::daemon {

/// The vehicle's own sensors: lines of a bus, samples and fixes in, samples for fusion out,
/// everything counted. Of the io thread.
class VehicleIntake {
 public:
  explicit VehicleIntake(std::optional<vehicle::VehicleDecoder> decoder)
      : decoder_(std::move(decoder)) {}

  /// Takes a line of a candump log and calls `on_sample(VehicleSample)` for what it says.
  template <class OnSample>
  void take_line(std::string_view line, Stamp stamp, OnSample on_sample) {
    can_.count(stamp);
    const std::optional<vehicle::CanFrame> frame = read(line);
    if (!frame || !decoder_) return;
    const vehicle::VehicleSamples samples = decoder_->decode(*frame);
    if (samples.wheels) on_sample(VehicleSample(*samples.wheels));
    if (samples.imu) on_sample(VehicleSample(*samples.imu));
    if (samples.wheels || samples.imu) ++can_.used;
  }

  void count(const ImuSample& sample) { count(imu_, sample.stamp); }
  void count(const GpsFix& fix) { count(gps_, fix.stamp); }

  /// What was wrong with the bus's log.
  const vehicle::ProblemLog& problems() const { return reader_.problems(); }

  const StreamCounters& can() const { return can_; }
  const StreamCounters& imu() const { return imu_; }
  const StreamCounters& gps() const { return gps_; }

 private:
  std::optional<vehicle::CanFrame> read(std::string_view line);
  static void count(StreamCounters& counters, Stamp stamp);

  vehicle::CandumpReader reader_{"can.log"};
  std::optional<vehicle::VehicleDecoder> decoder_;
  StreamCounters can_, imu_, gps_;
};

}  // namespace infuse::daemon
