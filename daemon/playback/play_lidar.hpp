#pragma once

#include <variant>

#include "daemon/pipeline/lidar_intake.hpp"
#include "daemon/pipeline/vehicle_intake.hpp"
#include "daemon/setup/drive_setup.hpp"

namespace infuse::daemon {

/// Plays a drive for one of its lidars and the vehicle's odometry. Calls `on_sweep(Sweep&)`,
/// `on_sample(const VehicleSample&)`, and after every event of the drive `on_event(const
/// DriveEvent&)`, which returns false to end early. At the drive's end the sweep being assembled is
/// passed on too. Returns the lidar's counters.
template <class OnSweep, class OnSample, class OnEvent>
LidarCounters play_lidar(SensorSetup& setup, size_t lidar, OnSweep on_sweep, OnSample on_sample,
                         OnEvent on_event) {
  LidarIntake intake(setup.lidars[lidar]);
  VehicleIntake vehicle(setup.vehicle);
  const auto on_fix = [&](const GnssFix& fix) {
    if (setup.gnss_lidar == lidar) on_sample(fix);
  };
  const auto on_gyros = [&](const GyroReadings& readings) { on_sample(readings); };
  const auto on_imu = [&](const ImuSample& sample) {
    if (!vehicle.has_inertial_unit()) on_sample(sample);
  };
  recording::DriveEvent event;
  while (setup.source.next(event)) {
    if (const auto* datagram = std::get_if<recording::DatagramEvent>(&event.content)) {
      if (datagram->lidar == lidar)
        intake.add_datagram(datagram->datagram, on_sweep, on_fix, on_gyros, on_imu);
    } else if (const auto* sweep = std::get_if<recording::SweepEvent>(&event.content)) {
      if (sweep->lidar == lidar) intake.add_sweep(*sweep->sweep, on_sweep);
    } else if (const auto* bus = std::get_if<recording::CanLineEvent>(&event.content)) {
      vehicle.add_can_line(bus->line, event.stamp, on_sample);
    } else if (const auto* speed = std::get_if<WheelOdometry>(&event.content)) {
      on_sample(*speed);
    } else if (const auto* imu = std::get_if<ImuSample>(&event.content)) {
      on_sample(*imu);
    } else if (const auto* fix = std::get_if<GnssFix>(&event.content)) {
      on_sample(*fix);
    }
    if (!on_event(event)) return intake.counters();
  }
  intake.finish(on_sweep);
  return intake.counters();
}

}  // namespace infuse::daemon
