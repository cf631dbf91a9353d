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

/// Index of a lidar, as in `PipelineSetup::lidars` and in the rig.
using LidarIndex = SensorIndex<struct LidarKind>;
/// Index of a camera, as in `PipelineSetup::cameras`; those of the rig come first.
using CameraIndex = SensorIndex<struct CameraKind>;
/// Index of a bus, as in `VehicleSetup::buses`.
using BusIndex = SensorIndex<struct BusKind>;

}  // namespace infuse::daemon
