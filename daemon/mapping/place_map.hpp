#pragma once

#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/mapping/map_folder.hpp"
#include "fusion/places/place_matcher.hpp"

namespace infuse::daemon {

/// Table of the places of a map as bytes, and back: a byte per cell in steps of `kHeightStep`, by
/// ring, sector and keyframe. Parsing fails where the size is not that of whole places.
std::string format_places(const std::vector<places::PlaceDescriptor>& places);
Result<std::vector<places::PlaceDescriptor>> parse_places(std::string_view bytes,
                                                          const std::string& name);

/// Reads the places of a map, one for every keyframe.
Result<std::vector<places::PlaceDescriptor>> read_places(const MapFolder& folder,
                                                         const MapDrive& drive);

/// Writes what a map is made of, drive.json last: `manifest` with the checksums of the tables,
/// which have an entry for every keyframe. The clouds are there already.
Result<void> write_drive(const MapFolder& folder, MapJson manifest,
                         const std::vector<MapKeyframe>& keyframes,
                         const std::vector<MapFix>& fixes,
                         const std::vector<places::PlaceDescriptor>& places);

/// Opens a complete map for localisation: its keyframes and places are read, its clouds, which must
/// be there, when they are needed.
Result<places::PlaceMap> open_place_map(const MapFolder& folder);

/// Digest of a complete map: `text::checksum` of map.json, which states the checksums of the other
/// files, by those of which every file is known.
Result<std::string> map_digest(const MapFolder& folder);

/// Reads every cloud. Fails at the first whose checksum is not that of the map, and where a stop is
/// requested.
Result<void> check_clouds(const places::PlaceMap& map, const std::stop_token& stop = {});

}  // namespace infuse::daemon
