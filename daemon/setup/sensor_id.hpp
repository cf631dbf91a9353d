#pragma once

#include <cstddef>
#include <cstdint>

namespace infuse::daemon {

/// Index of a sensor among those of its kind. Converts to an index of arrays, but not to the index
/// of another kind.
template <class Kind>
class SensorIndex {
 public:
  constexpr SensorIndex() = default;
  explicit constexpr SensorIndex(size_t value) : value_(static_cast<uint32_t>(value)) {}
  // NOLINTNEXTLINE(google-explicit-constructor): it indexes arrays
  constexpr operator size_t() const { return value_; }

 private:
  uint32_t value_ = 0;
};

/// Index of a lidar, as in `SensorSetup::lidars` and in the rig.
using LidarIndex = SensorIndex<struct LidarKind>;
/// Index of a camera, as in `SensorSetup::cameras`, and in the rig if it has a mount.
using CameraIndex = SensorIndex<struct CameraKind>;
/// Index of a bus, as in `VehicleSetup::buses`.
using BusIndex = SensorIndex<struct BusKind>;

/// Kinds of sensors.
enum class SensorKind : uint8_t { kLidar, kCamera, kBus, kSpeed, kImu, kGnss };

/// Names a sensor of a setup, of whatever kind.
struct SensorId {
  SensorKind kind = SensorKind::kLidar;
  size_t index = 0;  ///< LidarIndex, CameraIndex or BusIndex; 0 for the others

  bool operator==(const SensorId&) const = default;
};

}  // namespace infuse::daemon
