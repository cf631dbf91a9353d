#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/osm/openstreetmap.hpp"
#include "fusion/streetmap/map_from_image.hpp"
#include "fusion/streetmap/rasterise.hpp"
#include "fusion/streetmap/segment_map.hpp"

namespace infuse::daemon {

/// A street map that was read whole: what becomes of its file later changes nothing. Copies share
/// the bytes.
struct StreetMapFile {
  std::shared_ptr<const std::string> bytes;  ///< null: an empty map
  streetmap::SegmentMap map;                 ///< reads the bytes in place
  std::string digest;                        ///< `text::checksum` of the bytes
};

/// Reads a file that `infuse streetmap` wrote. Fails if it is missing, damaged or truncated,
/// or has more than 512 MiB; a large file of another kind is not read.
Result<StreetMapFile> open_street_map_file(const std::filesystem::path& path);

/// Settings of `make_street_map`.
struct StreetMapOptions {
  streetmap::RasterOptions raster;    ///< for OpenStreetMap input
  std::optional<osm::Bounds> clip{};  ///< of OpenStreetMap input; nothing: what the file states
  /// Called with what is done and its share; no share while that is unknown.
  std::function<void(std::optional<double>, const std::string&)> progress{};
  std::optional<streetmap::ImageMapOptions>
      image{};  ///< for PNG or JPEG input, which has no scale of its own
};

/// Generated street map.
struct GeneratedStreetMap {
  std::vector<std::byte> bytes;  ///< content of the file
  std::vector<Error> warnings;   ///< defects of the input, with element ids, few of each kind
};

/// Makes a map from OpenStreetMap (.osm, .osm.bz2, .osm.gz, .osm.pbf) or from an image (.png, .jpg,
/// .jpeg). Fails if the input cannot be read, has no drivable road, or is too large.
Result<GeneratedStreetMap> make_street_map(const std::filesystem::path& input,
                                           const StreetMapOptions& options);

/// True if the file name is that of an image.
bool is_image_file(const std::filesystem::path& input);

}  // namespace infuse::daemon
