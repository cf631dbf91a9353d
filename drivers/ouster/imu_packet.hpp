#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "drivers/measurement/vehicle_samples.hpp"

namespace infuse::ouster {

/// Bytes of an inertial packet's payload (`udp_profile_imu` LEGACY).
inline constexpr size_t kImuPacketSize = 48;

/// One sample of the sensor's inertial unit, as it sends it to port 7503, about a hundred times a
/// second. Axes are the inertial unit's.
struct ImuPacket {
  int64_t diagnostic_ns = 0;              ///< device time since power-up
  int64_t accelerometer_ns = 0;           ///< device time of the acceleration
  int64_t gyro_ns = 0;                    ///< device time of the rates
  std::array<float, 3> acceleration_g{};  ///< g, gravity included
  std::array<float, 3> rate_deg_per_s{};  ///< °/s
};

/// Parses a payload. Nothing if it has another size or a number that is not finite.
std::optional<ImuPacket> parse_imu_packet(std::span<const uint8_t> payload);

/// True if the bytes are an inertial packet by their content too: times that belong together and
/// values that a sensor can have.
bool is_imu_packet(std::span<const uint8_t> payload);

/// The sample in the sensor's axes (x forward, y left, z up) at `stamp`.
ImuSample to_sample(const ImuPacket& packet, const Eigen::Isometry3d& T_sensor_imu, Stamp stamp);

}  // namespace infuse::ouster
