#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "drivers/recording/drive_source.hpp"

namespace infuse::recording {

/// Rule that assigns datagrams to a lidar of the rig.
struct LidarRoute {
  size_t lidar = 0;
  uint16_t port = 0;
  uint16_t position_port = 0;
  std::optional<uint32_t> sender;  ///< absent: any
};

/// Opens the datagrams of a capture (a path as of `find_capture_parts`). If `routes` is empty, all
/// belong to lidar 0.
Result<std::unique_ptr<EventStream>> open_capture_stream(const std::filesystem::path& path,
                                                         const PcapOptions& options,
                                                         std::vector<LidarRoute> routes);

/// Opens the decoded sweeps of lidar `lidar`, whose files are `files`. The event of a sweep has the
/// stamp of its end. `times_trusted` is copied to their clock state; if it is false, a sweep has no
/// span, and its returns have no times unless they are deskewed.
Result<std::unique_ptr<EventStream>> open_sweep_stream(const std::filesystem::path& folder,
                                                       size_t lidar, const LidarFiles& files,
                                                       bool times_trusted);

/// Opens the images of camera `camera`; `stamp_delay` as `index_images`.
Result<std::unique_ptr<EventStream>> open_image_stream(const std::filesystem::path& folder,
                                                       size_t camera, Duration stamp_delay);

/// Opens the lines of a candump log: "(seconds.fraction) …". Other lines are skipped and noted.
Result<std::unique_ptr<EventStream>> open_can_stream(const std::filesystem::path& path);

/// Opens a speed.csv.
Result<std::unique_ptr<EventStream>> open_speed_stream(const std::filesystem::path& path);

/// Opens an imu.csv; `delay` is subtracted from its stamps.
Result<std::unique_ptr<EventStream>> open_imu_stream(const std::filesystem::path& path,
                                                     Duration delay);

/// Opens a gnss.csv.
Result<std::unique_ptr<EventStream>> open_gnss_stream(const std::filesystem::path& path);

}  // namespace infuse::recording
