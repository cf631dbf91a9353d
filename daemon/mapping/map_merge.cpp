#include "daemon/mapping/map_merge.hpp"

#include <algorithm>

#include "daemon/mapping/place_map.hpp"

namespace infuse::daemon {
namespace {

/// A map that is merged.
struct Part {
  MapFolder folder;
  MapContent content;
  std::vector<places::PlaceDescriptor> places;
};

Result<Part> open_part(const std::filesystem::path& path) {
  Part part{MapFolder(path), {}, {}};
  auto content = read_map(part.folder);
  if (!content) return tl::unexpected(content.error());
  part.content = *std::move(content);
  auto read = read_places(part.folder, part.content.drive);
  if (!read) return tl::unexpected(read.error());
  part.places = *std::move(read);
  return part;
}

Result<std::vector<Part>> open_parts(const MapFolder& target,
                                     const std::vector<std::filesystem::path>& maps) {
  constexpr double kSameMounting = 1e-6;
  std::vector<Part> parts;
  for (const std::filesystem::path& path : maps) {
    std::error_code ignored;
    if (std::filesystem::equivalent(path, target.path(), ignored)) {
      return fail("a map cannot be merged into itself", path.string(), "choose a new folder");
    }
    auto part = open_part(path);
    if (!part) return tl::unexpected(part.error());
    parts.push_back(*std::move(part));
    const MapDrive &first = parts.front().content.drive, &last = parts.back().content.drive;
    if (!first.T_vehicle_lidar.isApprox(last.T_vehicle_lidar, kSameMounting)) {
      return fail("the lidar is mounted elsewhere than that of the first map", path.string());
    }
  }
  return parts;
}

/// What the merged map is made of and how.
MapJson identity_of(const std::vector<Part>& parts, const MapSettings& settings) {
  MapJson json = make_manifest();
  json["sources"] = MapJson::array();
  json["merged"] = MapJson::array();
  for (const Part& part : parts) {
    for (const MapJson& source : part.content.manifest["sources"])
      json["sources"].push_back(source);
    json["merged"].push_back(part.content.manifest["files"]);
  }
  json["lidar"] = parts.front().content.manifest["lidar"];
  json["T_vehicle_lidar"] = parts.front().content.manifest["T_vehicle_lidar"];
  json["settings"] = to_json(settings);
  return json;
}

/// The drives one after the other.
MapDrive concatenate(const std::vector<Part>& parts) {
  MapDrive all;
  all.first_keyframes.clear();
  for (const Part& part : parts) {
    const size_t offset = all.keyframes.size();
    const double way = offset == 0 ? 0 : all.keyframes.back().keyframe.distance_driven;
    for (const size_t first : part.content.drive.first_keyframes) {
      all.first_keyframes.push_back(offset + first);
    }
    for (MapKeyframe keyframe : part.content.drive.keyframes) {
      keyframe.keyframe.distance_driven += way;
      all.keyframes.push_back(std::move(keyframe));
    }
    for (MapFix fix : part.content.drive.fixes) {
      fix.keyframe += offset;
      all.fixes.push_back(fix);
    }
  }
  return all;
}

Result<void> copy_clouds(const MapFolder& target, const std::vector<Part>& parts) {
  size_t k = 0;
  for (const Part& part : parts) {
    for (size_t i = 0; i < part.content.drive.keyframes.size(); ++i, ++k) {
      const auto bytes = part.folder.read(MapFolder::cloud_name(i),
                                          part.content.drive.keyframes[i].cloud_checksum);
      if (!bytes) return tl::unexpected(bytes.error());
      if (auto written = target.write(MapFolder::cloud_name(k), *bytes); !written) return written;
    }
  }
  target.remove_clouds_from(k);
  return {};
}

uint64_t sum_of(const std::vector<Part>& parts, const char* key) {
  uint64_t sum = 0;
  for (const Part& part : parts) {
    const MapJson& manifest = part.content.manifest;
    if (manifest.contains(key) && manifest[key].is_number_unsigned()) {
      sum += manifest[key].get<uint64_t>();
    }
  }
  return sum;
}

}  // namespace

Result<void> merge_maps(const MapFolder& target, const std::vector<std::filesystem::path>& maps,
                        const MapSettings& settings) {
  const auto parts = open_parts(target, maps);
  if (!parts) return tl::unexpected(parts.error());
  if (auto created = target.create(); !created) return created;
  MapJson manifest = identity_of(*parts, settings);
  const auto made = target.is_made_of(manifest);
  if (!made) return tl::unexpected(made.error());
  if (*made) return {};
  target.remove_results();
  if (auto copied = copy_clouds(target, *parts); !copied) return copied;

  const MapDrive all = concatenate(*parts);
  manifest[kFirstKeyframes] = all.first_keyframes;
  for (const char* key : {"sweeps", "unmeasured", "unregistered"}) {
    manifest[key] = sum_of(*parts, key);
  }
  std::vector<places::PlaceDescriptor> places;
  for (const Part& part : *parts) {
    places.insert(places.end(), part.places.begin(), part.places.end());
  }
  return write_drive(target, std::move(manifest), all.keyframes, all.fixes, places);
}

}  // namespace infuse::daemon
