#include "daemon/mapping/map_merge.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "daemon/mapping/place_map.hpp"
#include "drivers/text/checksum.hpp"

namespace infuse::daemon {
namespace {

/// A map that is merged.
struct Part {
  MapFolder folder;
  MapContent content;
  std::vector<places::PlaceDescriptor> places;
  std::vector<mapping::Closure> closures;  ///< that its map is made of
};

/// The closures that a complete map is made of.
Result<std::vector<mapping::Closure>> read_closures(const MapFolder& folder,
                                                    const MapContent& content) {
  auto sought =
      folder.read_stated(content.manifest, map_file::kClosures).and_then([&](const auto& text) {
        return parse_closures(text, folder.path_of(map_file::kClosures));
      });
  if (!sought) return sought;
  for (const mapping::Closure& closure : *sought) {  // of which `from` is the less
    if (closure.to >= content.drive.keyframes.size()) {
      return fail("a closure of a keyframe that does not exist",
                  folder.path_of(map_file::kClosures));
    }
  }
  std::vector<mapping::Closure> closures = content.drive.closures;
  closures.insert(closures.end(), sought->begin(), sought->end());
  std::set<std::pair<size_t, size_t>> outvoted;
  for (const MapJson& pair : content.manifest.value("outvoted_closures", MapJson::array())) {
    const bool sound = pair.is_array() && pair.size() == 2 && pair[0].is_number_unsigned() &&
                       pair[1].is_number_unsigned();
    if (!sound) {
      return fail("outvoted_closures are not pairs of keyframes", folder.path_of(map_file::kMap));
    }
    outvoted.emplace(pair[0].get<size_t>(), pair[1].get<size_t>());
  }
  std::erase_if(closures, [&](const mapping::Closure& closure) {
    return !closure.accepted() || outvoted.contains({closure.from, closure.to});
  });
  return closures;
}

Result<Part> open_part(const std::filesystem::path& path) {
  Part part{MapFolder(path), {}, {}, {}};
  auto content = read_map(part.folder);
  if (!content) return tl::unexpected(content.error());
  part.content = *std::move(content);
  auto read = read_places(part.folder, part.content.drive);
  if (!read) return tl::unexpected(read.error());
  part.places = *std::move(read);
  auto closures = read_closures(part.folder, part.content);
  if (!closures) return tl::unexpected(closures.error());
  part.closures = *std::move(closures);
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

/// What the merged map is made of and how. Fails if a manifest does not say.
Result<MapJson> identity_of(const std::vector<Part>& parts, const MapSettings& settings) {
  for (const Part& part : parts) {
    for (const char* key : {"sources", "files", "lidar", "T_vehicle_lidar"}) {
      if (!part.content.manifest.contains(key)) {
        return fail("\"" + std::string(key) + "\" is missing", part.folder.path_of(map_file::kMap),
                    "make the map anew");
      }
    }
  }
  MapJson json = make_manifest();
  json["sources"] = MapJson::array();
  json["merged"] = MapJson::array();
  for (const Part& part : parts) {
    for (const MapJson& source : part.content.manifest.at("sources"))
      json["sources"].push_back(source);
    json["merged"].push_back(part.content.manifest.at("files"));
  }
  json["lidar"] = parts.front().content.manifest.at("lidar");
  json["T_vehicle_lidar"] = parts.front().content.manifest.at("T_vehicle_lidar");
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
    for (mapping::Closure closure : part.closures) {
      closure.from += offset;
      closure.to += offset;
      all.closures.push_back(std::move(closure));
    }
  }
  std::stable_sort(all.closures.begin(), all.closures.end(),
                   [](const auto& a, const auto& b) { return a.to < b.to; });
  return all;
}

Result<void> copy_clouds(const MapFolder& target, const std::vector<Part>& parts) {
  size_t k = 0;
  std::vector<size_t> copied;
  for (const Part& part : parts) {
    for (size_t i = 0; i < part.content.drive.keyframes.size(); ++i, ++k) {
      if (!part.content.drive.keyframes[i].keyframe.has_cloud) continue;
      const auto bytes = part.folder.read(MapFolder::cloud_name(i),
                                          part.content.drive.keyframes[i].cloud_checksum);
      if (!bytes) return tl::unexpected(bytes.error());
      if (auto written = target.write(MapFolder::cloud_name(k), *bytes); !written) return written;
      copied.push_back(k);
    }
  }
  target.keep_clouds(copied);  // an interrupted run of other content may have left some
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
  auto identity = identity_of(*parts, settings);
  if (!identity) return tl::unexpected(identity.error());
  MapJson manifest = *std::move(identity);
  if (auto created = target.create(); !created) return created;
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
  const std::string closures = format_closures(all.closures);
  if (auto written = target.write(map_file::kEarlierClosures, closures); !written) return written;
  manifest["files"][map_file::kEarlierClosures] = text::checksum(closures);
  std::vector<places::PlaceDescriptor> places;
  for (const Part& part : *parts) {
    places.insert(places.end(), part.places.begin(), part.places.end());
  }
  return write_drive(target, std::move(manifest), all.keyframes, all.fixes, places);
}

}  // namespace infuse::daemon
