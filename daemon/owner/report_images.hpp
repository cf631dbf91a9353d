#pragma once

#include <filesystem>

#include "daemon/pages/report_data.hpp"
#include "daemon/protocol/json.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "fusion/streetmap/segment_map.hpp"

namespace infuse::daemon {

/// Lidar over image of each camera of the reports, with the calibration in use at the first report
/// and at the end: [{device, name, t, before, after}], without `after` if it is the same. After a
/// drift, images from its begin on are drawn. A camera whose images cannot be read is left out,
/// with a note in `notes`.
Json overlay_images(const std::filesystem::path& drive, const ReportData& reports, Json& notes);

/// The sweep of the first lidar at `stamp`, or the next one, from above, as measured and deskewed:
/// {url, stamp_ns, seam (rad, azimuth at which it begins), metres (to each side)}; null if there is
/// none.
Json sweep_image_json(const std::filesystem::path& path, Stamp stamp);

/// The part of a street map around a path (x, y in m, map frame): {url, x, y, width, height}, the
/// corner in the south-west and the size in m; null if the path is not on the map.
Json map_image(const streetmap::SegmentMap& map, const Eigen::AlignedBox2d& path);

}  // namespace infuse::daemon
