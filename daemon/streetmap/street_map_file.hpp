#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "drivers/recording/mapped_file.hpp"
#include "fusion/streetmap/map_from_image.hpp"
#include "fusion/streetmap/rasterise.hpp"
#include "fusion/streetmap/segment_map.hpp"

namespace infuse::daemon {

/// A street map file in memory, and the map that reads it in place.
struct StreetMapFile {
  recording::MappedFile file;
  streetmap::SegmentMap map;
};

/// Maps a file that `infuse streetmap` wrote. Fails where it is missing, damaged or cut off.
Result<StreetMapFile> open_street_map_file(const std::filesystem::path& path);

/// The same of a name in a folder; an empty map where the name is empty.
Result<StreetMapFile> open_optional_street_map_file(const std::filesystem::path& folder,
                                                    const std::string& name);

/// What a street map is made with.
struct StreetMapOptions {
  streetmap::RasterOptions raster;                    ///< for OpenStreetMap
  std::optional<streetmap::ImageMapOptions> image{};  ///< for a PNG or JPEG, which has no scale
};

/// A street map to be written.
struct GeneratedStreetMap {
  std::vector<std::byte> bytes;  ///< the file
  std::vector<Error> warnings;   ///< what of the input is not as it should be, with element ids
};

/// Makes a map of OpenStreetMap XML (.osm, .osm.bz2, .osm.gz) or of a picture (.png, .jpg, .jpeg).
/// Fails where the input cannot be read, has no road that can be driven on, or is too large.
Result<GeneratedStreetMap> make_street_map(const std::filesystem::path& input,
                                           const StreetMapOptions& options);

/// Whether the name is a picture's.
bool is_image_file(const std::filesystem::path& input);

}  // namespace infuse::daemon
