#pragma once

#include <string>
#include <string_view>

#include "drivers/measurement/error.hpp"
#include "fusion/mapping/submap.hpp"

namespace infuse::daemon {

/// Formats a cloud with the fields x, y, z (m) and intensity (reflectivity, 0 … 1), all float32.
std::string format_cloud_pcd(const mapping::Submap& cloud);  ///< Point Cloud Library, binary
std::string format_cloud_ply(const mapping::Submap& cloud);  ///< Stanford polygon, little-endian

/// Parses the bytes of `format_cloud_pcd`. Fails if they are of another format, are cut, or a point
/// is not finite.
Result<mapping::Submap> parse_cloud_pcd(std::string_view bytes, const std::string& name);

/// The bytes of `format_cloud_pcd` compressed (Zstandard), half as many, and back: of a cloud with
/// so many points.
Result<std::string> compress_cloud(const mapping::Submap& cloud);
Result<mapping::Submap> parse_compressed_cloud(std::string_view bytes, size_t points,
                                               const std::string& name);

}  // namespace infuse::daemon
