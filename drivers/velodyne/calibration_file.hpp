#pragma once

#include <filesystem>
#include <string_view>

#include "drivers/measurement/error.hpp"
#include "drivers/velodyne/calibration.hpp"

namespace infuse::velodyne {

/// Reads an HDL-64E's `db.xml` as the vendor ships it: angles in degrees, lengths in centimetres.
/// All 64 lasers must be there. Errors: not XML, too large or too deep, a laser or a number
/// missing, a number that is impossible.
Result<Calibration> parse_db_xml(std::string_view text);

/// The same from a file of at most 4 MiB.
Result<Calibration> load_db_xml(const std::filesystem::path& path);

}  // namespace infuse::velodyne
