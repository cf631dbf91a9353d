#include "drivers/ouster/imu_packet.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "drivers/lidar/little_endian.hpp"
#include "drivers/measurement/angles.hpp"

namespace infuse::ouster {
namespace {

/// Full scale of the inertial units that are in use, with room.
constexpr float kMaxAccelerationG = 64;
constexpr float kMaxRateDegPerS = 8000;
constexpr int64_t kMaxTimeBetweenNs = 1'000'000'000;
constexpr double kStandardGravity = 9.80665;  // m/s²

int64_t read_time(const uint8_t* bytes) {
  return static_cast<int64_t>(lidar::read_u64(bytes) & INT64_MAX);
}

bool read_vector(const uint8_t* bytes, std::array<float, 3>& vector) {
  for (size_t i = 0; i < vector.size(); ++i) {
    vector[i] = std::bit_cast<float>(lidar::read_u32(bytes + 4 * i));
    if (!std::isfinite(vector[i])) return false;
  }
  return true;
}

std::array<double, 3> rotate(const Eigen::Isometry3d& T, const std::array<float, 3>& vector,
                             double unit) {
  const Eigen::Vector3d rotated =
      T.linear() * (Eigen::Vector3f(vector.data()).cast<double>() * unit);
  return {rotated.x(), rotated.y(), rotated.z()};
}

}  // namespace

std::optional<ImuPacket> parse_imu_packet(std::span<const uint8_t> payload) {
  if (payload.size() != kImuPacketSize) return std::nullopt;
  ImuPacket packet;
  packet.diagnostic_ns = read_time(payload.data());
  packet.accelerometer_ns = read_time(payload.data() + 8);
  packet.gyro_ns = read_time(payload.data() + 16);
  if (!read_vector(payload.data() + 24, packet.acceleration_g)) return std::nullopt;
  if (!read_vector(payload.data() + 36, packet.rate_deg_per_s)) return std::nullopt;
  return packet;
}

bool is_imu_packet(std::span<const uint8_t> payload) {
  const auto packet = parse_imu_packet(payload);
  if (!packet || packet->gyro_ns == 0) return false;
  // No clock counts beyond 292 years.
  if (lidar::read_u64(payload.data() + 16) > uint64_t{INT64_MAX}) return false;
  const auto within = [](const std::array<float, 3>& values, float limit) {
    return std::ranges::all_of(values, [limit](float value) { return std::abs(value) <= limit; });
  };
  return std::abs(packet->gyro_ns - packet->accelerometer_ns) <= kMaxTimeBetweenNs &&
         within(packet->acceleration_g, kMaxAccelerationG) &&
         within(packet->rate_deg_per_s, kMaxRateDegPerS);
}

ImuSample to_sample(const ImuPacket& packet, const Eigen::Isometry3d& T_sensor_imu, Stamp stamp) {
  return {stamp, rotate(T_sensor_imu, packet.rate_deg_per_s, kDegree),
          rotate(T_sensor_imu, packet.acceleration_g, kStandardGravity)};
}

}  // namespace infuse::ouster
