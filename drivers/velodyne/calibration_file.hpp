#pragma once

#include <filesystem>
#include <string_view>

#include "drivers/measurement/error.hpp"
#include "drivers/velodyne/calibration.hpp"

namespace infuse::velodyne {

/// Parses an HDL-64E's `db.xml` as the vendor ships it: angles in degrees, lengths in centimetres.
/// All 64 lasers must be present. Errors: not XML, too large or too deep, a missing laser or
/// number, an impossible number.
Result<Calibration> parse_db_xml(std::string_view text);

/// Parses a file of at most 4 MiB.
Result<Calibration> load_db_xml(const std::filesystem::path& path);

}  // namespace infuse::velodyne
