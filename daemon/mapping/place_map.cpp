#include "daemon/mapping/place_map.hpp"

#include <cmath>

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

Result<places::PlaceMap> open_place_map(const MapFolder& folder) {
  auto content = read_map(folder);
  if (!content) return tl::unexpected(content.error());
  auto descriptors =
      folder.read_stated(content->drive.manifest, map_file::kPlaces).and_then([&](const auto& b) {
        return parse_places(b, folder.path_of(map_file::kPlaces));
      });
  if (!descriptors) return tl::unexpected(descriptors.error());
  if (descriptors->size() != content->drive.keyframes.size()) {
    return fail("not as many places as keyframes", folder.path_of(map_file::kPlaces));
  }
  places::PlaceMap map;
  map.T_map_vehicle = std::move(content->T_map_vehicle);
  map.T_vehicle_lidar = content->drive.T_vehicle_lidar;
  map.descriptors = *std::move(descriptors);
  map.read_cloud = [folder, keyframes = std::move(content->drive.keyframes)](size_t k) {
    return folder.read_cloud(keyframes, k);
  };
  return map;
}

}  // namespace infuse::daemon
