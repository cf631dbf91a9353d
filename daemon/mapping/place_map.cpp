#include "daemon/mapping/place_map.hpp"

#include <cmath>

#include "drivers/text/checksum.hpp"

namespace infuse::daemon {

using places::PlaceDescriptor;

std::string format_places(const std::vector<PlaceDescriptor>& places) {
  std::string bytes;
  bytes.reserve(places.size() * places::kRings * places::kSectors);
  for (const PlaceDescriptor& place : places) {
    for (const float height : place.heights.reshaped()) {
      bytes.push_back(static_cast<char>(
          static_cast<uint8_t>(std::lround(static_cast<double>(height) / places::kHeightStep))));
    }
  }
  return bytes;
}

Result<std::vector<PlaceDescriptor>> parse_places(std::string_view bytes, const std::string& name) {
  constexpr size_t kBytes = size_t{places::kRings} * places::kSectors;
  if (bytes.size() % kBytes != 0) return fail("not a table of places", name);
  std::vector<PlaceDescriptor> places(bytes.size() / kBytes);
  size_t at = 0;
  for (PlaceDescriptor& place : places) {
    for (float& height : place.heights.reshaped()) {
      height = static_cast<float>(static_cast<uint8_t>(bytes[at++]) * places::kHeightStep);
    }
  }
  return places;
}

Result<std::vector<PlaceDescriptor>> read_places(const MapFolder& folder, const MapDrive& drive) {
  auto places = folder.read_stated(drive.manifest, map_file::kPlaces).and_then([&](const auto& b) {
    return parse_places(b, folder.path_of(map_file::kPlaces));
  });
  if (places && places->size() != drive.keyframes.size()) {
    return fail("not as many places as keyframes", folder.path_of(map_file::kPlaces));
  }
  return places;
}

Result<void> write_drive(const MapFolder& folder, MapJson manifest,
                         const std::vector<MapKeyframe>& keyframes,
                         const std::vector<MapFix>& fixes,
                         const std::vector<PlaceDescriptor>& places) {
  const std::string keyframes_text = format_keyframes(keyframes), fixes_text = format_fixes(fixes),
                    places_bytes = format_places(places);
  for (const auto& [name, text] :
       {std::pair{map_file::kKeyframes, &keyframes_text}, std::pair{map_file::kFixes, &fixes_text},
        std::pair{map_file::kPlaces, &places_bytes}}) {
    if (auto written = folder.write(name, *text); !written) return written;
    manifest["files"][name] = text::checksum(*text);
  }
  return folder.write(map_file::kDrive,
                      manifest.dump(1, ' ', false, MapJson::error_handler_t::replace) + "\n");
}

Result<places::PlaceMap> open_place_map(const MapFolder& folder) {
  auto content = read_map(folder);
  if (!content) return tl::unexpected(content.error());
  auto descriptors = read_places(folder, content->drive);
  if (!descriptors) return tl::unexpected(descriptors.error());
  places::PlaceMap map;
  std::vector<size_t> keyframe_of;  // by place
  for (size_t k = 0; k < content->drive.keyframes.size(); ++k) {
    if (!content->drive.keyframes[k].keyframe.has_cloud) continue;
    if (const std::string name = MapFolder::cloud_name(k); !folder.has(name)) {
      return fail("is missing", folder.path_of(name), "make the map anew, or copy all of it");
    }
    keyframe_of.push_back(k);
    map.T_map_vehicle.push_back(content->T_map_vehicle[k]);
    map.descriptors.push_back((*descriptors)[k]);
  }
  map.T_vehicle_lidar = content->drive.T_vehicle_lidar;
  map.read_cloud = [folder, keyframe_of = std::move(keyframe_of),
                    keyframes = std::move(content->drive.keyframes)](size_t place) {
    return folder.read_cloud(keyframes, keyframe_of[place]);
  };
  return map;
}

Result<std::string> map_digest(const MapFolder& folder) {
  return folder.read(map_file::kMap).map([](const auto& bytes) { return text::checksum(bytes); });
}

Result<void> check_clouds(const places::PlaceMap& map, const std::stop_token& stop) {
  for (size_t k = 0; k < map.descriptors.size(); ++k) {
    if (stop.stop_requested()) return fail("was not read to its end");
    if (auto cloud = map.read_cloud(k); !cloud) return tl::unexpected(cloud.error());
  }
  return {};
}

}  // namespace infuse::daemon
