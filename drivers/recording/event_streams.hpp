#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "drivers/recording/drive_source.hpp"

namespace infuse::recording {

/// Which lidar of the rig a datagram belongs to.
struct LidarRoute {
  size_t lidar = 0;
  uint16_t port = 0;
  uint16_t position_port = 0;
  std::optional<uint32_t> sender;  ///< absent: any
};

/// The datagrams of a capture; `routes` empty: all are lidar 0's.
Result<std::unique_ptr<EventStream>> open_capture_stream(const std::filesystem::path& path,
                                                         const PcapOptions& options,
                                                         std::vector<LidarRoute> routes);

/// Decoded sweeps of lidar `lidar`. `times_trusted` goes into their clock state.
Result<std::unique_ptr<EventStream>> open_sweep_stream(const std::filesystem::path& folder,
                                                       size_t lidar, bool times_trusted);

/// Pictures of camera `camera`; `stamp_delay` is subtracted from their stamps.
Result<std::unique_ptr<EventStream>> open_image_stream(const std::filesystem::path& folder,
                                                       size_t camera, Duration stamp_delay);

/// Lines of a candump log: "(seconds.fraction) …"; others are left out and noted.
Result<std::unique_ptr<EventStream>> open_can_stream(const std::filesystem::path& path);

Result<std::unique_ptr<EventStream>> open_imu_stream(const std::filesystem::path& path);
Result<std::unique_ptr<EventStream>> open_gnss_stream(const std::filesystem::path& path);

}  // namespace infuse::recording
