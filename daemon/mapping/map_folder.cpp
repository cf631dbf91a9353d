#include "daemon/mapping/map_folder.hpp"

#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <set>
#include <utility>

#include "daemon/mapping/cloud_file.hpp"
#include "daemon/mapping/g2o_file.hpp"
#include "drivers/recording/atomic_file.hpp"
#include "drivers/recording/rigid_matrix.hpp"
#include "drivers/text/checksum.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kMapFormat = "infuse map";
constexpr int kMapVersion = 3;
constexpr const char* kCloudEnding = ".pcd.zst";
constexpr size_t kMaxMapFileBytes = size_t{256} << 20;
constexpr std::array kMapFileNames{
    map_file::kDrive,    map_file::kKeyframes,       map_file::kFixes, map_file::kPlaces,
    map_file::kClosures, map_file::kEarlierClosures, map_file::kGraph, map_file::kTrajectory,
    map_file::kMap,      map_file::kClouds};

bool is_map_file(const std::string& name) {
  return std::any_of(kMapFileNames.begin(), kMapFileNames.end(),
                     [&](const char* known) { return name.starts_with(known); }) ||
         name.starts_with('.');
}

/// True for the name of a cloud that a map writes: digits and the ending.
bool is_cloud_name(std::string_view name) {
  const size_t digits = std::min(name.find_first_not_of("0123456789"), name.size());
  return digits > 0 && name.substr(digits) == kCloudEnding;
}

/// True for what a map has in its clouds' folder: clouds, and what an interrupted write leaves.
bool is_cloud_file(const std::string& name) {
  return name.starts_with('.') || is_cloud_name(name) ||
         is_cloud_name(recording::target_of_temporary(name));
}

/// Fails if a folder that may exist holds a file that no map has.
template <class IsOurs>
Result<void> check_names(const std::filesystem::path& folder, IsOurs is_ours) {
  std::error_code error;
  for (std::filesystem::directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (!is_ours(name)) {
      return fail("the folder holds '" + name + "', which is not part of a map", folder.string(),
                  "choose a new folder");
    }
  }
  return {};
}

/// Removes the temporary files that an interrupted write leaves.
void remove_leftovers(const std::filesystem::path& folder) {
  std::error_code error;
  std::vector<std::filesystem::path> leftovers;
  for (std::filesystem::directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    const std::string name = it->path().filename().string();
    const std::string_view stem = recording::target_of_temporary(name);
    const bool is_ours = stem.ends_with(".zst") || stem.ends_with(".csv") ||
                         stem.ends_with(".json") || stem.ends_with(".g2o") ||
                         stem.ends_with(".tum") || stem.ends_with(".bin");
    if (is_ours) leftovers.push_back(it->path());
  }
  for (const auto& leftover : leftovers) std::filesystem::remove(leftover, error);
}

/// The text at a key, or nothing.
std::string text_at(const MapJson& json, const std::string& key) {
  if (!json.is_object() || !json.contains(key) || !json[key].is_string()) return "";
  return json[key].get<std::string>();
}

Result<Eigen::Isometry3d> read_mounting(const MapJson& manifest, const std::string& where) {
  const auto wrong = [&] { return fail("T_vehicle_lidar is not a rigid motion", where); };
  if (!manifest.contains("T_vehicle_lidar")) return wrong();
  const MapJson& numbers = manifest["T_vehicle_lidar"];
  if (!numbers.is_array() || numbers.size() != 16) return wrong();
  std::array<double, 16> by_row{};
  for (size_t i = 0; i < 16; ++i) {
    if (!numbers[i].is_number()) return wrong();
    by_row[i] = numbers[i].get<double>();
  }
  const auto T = recording::to_rigid(by_row);
  if (!T) return wrong();
  return *T;
}

/// The first keyframes of a merged map's drives, or 0. Fails where they or a drive's stamps are not
/// in order.
Result<std::vector<size_t>> read_first_keyframes(const MapJson& manifest,
                                                 const std::vector<MapKeyframe>& keyframes,
                                                 const std::string& where) {
  std::vector<size_t> first{0};
  if (manifest.contains(kFirstKeyframes)) {
    const MapJson& numbers = manifest[kFirstKeyframes];
    if (!numbers.is_array() || numbers.empty() || numbers[0] != 0) {
      return fail("first_keyframes is not a list that begins with 0", where);
    }
    for (size_t d = 1; d < numbers.size(); ++d) {
      if (!numbers[d].is_number_unsigned() || numbers[d].get<size_t>() <= first.back() ||
          numbers[d].get<size_t>() >= keyframes.size()) {
        return fail("first_keyframes are not keyframes in order", where);
      }
      first.push_back(numbers[d].get<size_t>());
    }
  }
  for (size_t k = 1; k < keyframes.size(); ++k) {
    const bool begins = std::binary_search(first.begin(), first.end(), k);
    if (!begins && keyframes[k].keyframe.stamp <= keyframes[k - 1].keyframe.stamp) {
      return fail(fmt::format("the stamp of keyframe {} goes back", k), where);
    }
  }
  return first;
}

/// Leaves the clouds to the keyframes that a complete map states, in order.
Result<void> apply_kept_clouds(const MapJson& manifest, std::vector<MapKeyframe>& keyframes,
                               const std::string& where) {
  if (!manifest.contains(kKeptClouds)) return {};
  const MapJson& kept = manifest[kKeptClouds];
  size_t k = 0;
  for (const MapJson& number : kept) {
    if (!number.is_number_unsigned() || number.get<size_t>() < k ||
        number.get<size_t>() >= keyframes.size() ||
        !keyframes[number.get<size_t>()].keyframe.has_cloud) {
      return fail("clouds are not keyframes in order", where);
    }
    for (; k < number.get<size_t>(); ++k) keyframes[k].drop_cloud();
    ++k;
  }
  for (; k < keyframes.size(); ++k) keyframes[k].drop_cloud();
  return {};
}

}  // namespace

Result<MapFolder> MapFolder::hold() const {
  host::FileDescriptor folder(::open(path_.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
  if (!folder) {
    return fail(std::string("cannot be opened: ") + std::strerror(errno), path_.string());
  }
  MapFolder held(path_);
  held.opened_ = "/proc/self/fd/" + std::to_string(folder.get());
  held.held_ = std::make_shared<const host::FileDescriptor>(std::move(folder));
  return held;
}

MapFolder::Id MapFolder::id() const {
  struct stat about {};
  if (::stat(opened_.c_str(), &about) != 0) return {};
  return {about.st_dev, about.st_ino};
}

bool MapFolder::has(const std::string& name) const {
  std::error_code ignored;
  return std::filesystem::exists(opened_ / name, ignored);
}

Result<void> MapFolder::create() const {
  std::error_code error;
  if (std::filesystem::exists(path_, error)) {
    if (!std::filesystem::is_directory(path_, error)) return fail("not a folder", path_.string());
    if (auto checked = check_names(path_, is_map_file); !checked) return checked;
    // Where there is a map, of an earlier version too, its manifest decides.
    if (!has(map_file::kDrive)) {
      auto checked = check_names(path_ / map_file::kClouds, is_cloud_file);
      if (!checked) return checked;
    }
  }
  std::filesystem::create_directories(path_ / map_file::kClouds, error);
  if (error) return fail("cannot be created: " + error.message(), path_.string());
  remove_leftovers(path_);
  remove_leftovers(path_ / map_file::kClouds);
  return {};
}

Result<void> MapFolder::write(const std::string& name, std::string_view bytes) const {
  return recording::write_file_atomically(path_ / name,
                                          std::as_bytes(std::span(bytes.data(), bytes.size())));
}

Result<std::string> MapFolder::read(const std::string& name, const std::string& sum) const {
  auto bytes = text::read_text(opened_ / name, kMaxMapFileBytes);
  if (!bytes) return fail(bytes.error().what, path_of(name), bytes.error().hint);
  if (!sum.empty() && text::checksum(*bytes) != sum) {
    return fail("the file is damaged: its checksum is not the stated one", path_of(name),
                "make the map anew");
  }
  return bytes;
}

Result<MapJson> MapFolder::read_manifest(const std::string& name) const {
  const auto text = read(name);
  if (!text) return tl::unexpected(text.error());
  MapJson json = MapJson::parse(*text, nullptr, false);
  if (text_at(json, "format") != kMapFormat) {
    return fail("not the manifest of a map, or damaged", path_of(name));
  }
  if (json["version"] != kMapVersion) {
    return fail("a map of version " + json["version"].dump(), path_of(name),
                "make the map anew with infuse map");
  }
  return json;
}

Result<bool> MapFolder::is_made_of(const MapJson& identity) const {
  if (!has(map_file::kDrive)) return false;
  const auto manifest = read_manifest(map_file::kDrive);
  if (!manifest) return tl::unexpected(manifest.error());
  for (const auto& [key, value] : identity.items()) {
    if (!manifest->contains(key) || (*manifest)[key] != value) {
      return fail("the folder holds a map of another drive, lidar or settings (" + key + ")",
                  path_.string(), "choose a new folder");
    }
  }
  return true;
}

void MapFolder::keep_clouds(const std::vector<size_t>& kept) const {
  std::set<std::string> names;
  for (const size_t k : kept) names.insert(std::filesystem::path(cloud_name(k)).filename());
  std::vector<std::filesystem::path> others;
  std::error_code error;
  for (std::filesystem::directory_iterator it(path_ / map_file::kClouds, error), end;
       !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (is_cloud_name(name) && !names.contains(name)) others.push_back(it->path());
  }
  for (const auto& other : others) std::filesystem::remove(other, error);
}

void MapFolder::remove_results() const {
  for (const char* later : {map_file::kClosures, map_file::kMap}) {
    std::error_code ignored;
    std::filesystem::remove(path_ / later, ignored);
  }
}

Result<std::string> MapFolder::read_stated(const MapJson& manifest, const std::string& name) const {
  const std::string sum =
      manifest.contains("files") ? text_at(manifest["files"], name) : std::string();
  if (sum.empty()) return fail("the manifest does not state this file", path_of(name));
  return read(name, sum);
}

std::string MapFolder::cloud_name(size_t keyframe) {
  return fmt::format("{}/{:06}{}", map_file::kClouds, keyframe, kCloudEnding);
}

std::string MapFolder::trajectory_name(size_t drive) {
  return drive == 0 ? fmt::format("{}.tum", map_file::kTrajectory)
                    : fmt::format("{}_{}.tum", map_file::kTrajectory, drive + 1);
}

Result<std::string> MapFolder::write_cloud(size_t keyframe, const mapping::Submap& cloud) const {
  const auto bytes = compress_cloud(cloud);
  if (!bytes) return tl::unexpected(bytes.error());
  return write(cloud_name(keyframe), *bytes).map([&] { return text::checksum(*bytes); });
}

Result<mapping::Submap> MapFolder::read_cloud(const std::vector<MapKeyframe>& keyframes,
                                              size_t k) const {
  const std::string name = cloud_name(k);
  return read(name, keyframes[k].cloud_checksum).and_then([&](const std::string& bytes) {
    return parse_compressed_cloud(bytes, keyframes[k].points, path_of(name));
  });
}

MapJson make_manifest() { return {{"format", kMapFormat}, {"version", kMapVersion}}; }

Result<MapDrive> read_map_drive(const MapFolder& folder) {
  MapDrive drive;
  auto manifest = folder.read_manifest(map_file::kDrive);
  if (!manifest) return tl::unexpected(manifest.error());
  drive.manifest = *std::move(manifest);
  const auto mounting = read_mounting(drive.manifest, folder.path_of(map_file::kDrive));
  if (!mounting) return tl::unexpected(mounting.error());
  drive.T_vehicle_lidar = *mounting;
  auto keyframes =
      folder.read_stated(drive.manifest, map_file::kKeyframes).and_then([&](const auto& text) {
        return parse_keyframes(text, folder.path_of(map_file::kKeyframes));
      });
  if (!keyframes) return tl::unexpected(keyframes.error());
  drive.keyframes = *std::move(keyframes);
  auto first =
      read_first_keyframes(drive.manifest, drive.keyframes, folder.path_of(map_file::kDrive));
  if (!first) return tl::unexpected(first.error());
  drive.first_keyframes = *std::move(first);
  auto fixes = folder.read_stated(drive.manifest, map_file::kFixes).and_then([&](const auto& text) {
    return parse_fixes(text, folder.path_of(map_file::kFixes));
  });
  if (!fixes) return tl::unexpected(fixes.error());
  drive.fixes = *std::move(fixes);
  for (const MapFix& fix : drive.fixes) {
    if (fix.keyframe >= drive.keyframes.size()) {
      return fail("a fix of a keyframe that does not exist", folder.path_of(map_file::kFixes));
    }
  }
  if (!drive.manifest["files"].contains(map_file::kEarlierClosures)) return drive;
  auto closures = folder.read_stated(drive.manifest, map_file::kEarlierClosures)
                      .and_then([&](const auto& text) {
                        return parse_closures(text, folder.path_of(map_file::kEarlierClosures));
                      });
  if (!closures) return tl::unexpected(closures.error());
  for (const mapping::Closure& closure : *closures) {
    if (closure.to >= drive.keyframes.size()) {
      return fail("a closure of a keyframe that does not exist",
                  folder.path_of(map_file::kEarlierClosures));
    }
  }
  drive.closures = *std::move(closures);
  return drive;
}

Result<MapContent> read_map(const MapFolder& folder) {
  MapContent map;
  if (!folder.has(map_file::kMap)) {
    return fail(folder.has(map_file::kDrive) ? "the map is not complete" : "not a map",
                folder.path().string(),
                "run infuse map DRIVE -o MAP; it goes on where it was interrupted");
  }
  auto manifest = folder.read_manifest(map_file::kMap);
  if (!manifest) return tl::unexpected(manifest.error());
  map.manifest = *std::move(manifest);
  if (auto stated = folder.read_stated(map.manifest, map_file::kDrive); !stated) {
    return tl::unexpected(stated.error());
  }
  auto drive = read_map_drive(folder);
  if (!drive) return tl::unexpected(drive.error());
  map.drive = *std::move(drive);
  if (auto kept =
          apply_kept_clouds(map.manifest, map.drive.keyframes, folder.path_of(map_file::kMap));
      !kept) {
    return tl::unexpected(kept.error());
  }
  const std::string graph_file = folder.path_of(map_file::kGraph);
  const auto graph =
      folder.read_stated(map.manifest, map_file::kGraph).and_then([&](const auto& text) {
        return parse_g2o(text, graph_file);
      });
  if (!graph) return tl::unexpected(graph.error());
  const auto* spatial = std::get_if<G2oGraph<3>>(&*graph);
  if (spatial == nullptr || !spatial->has_poses) return fail("not the graph of a map", graph_file);
  for (size_t i = 0; i < spatial->ids.size(); ++i) {
    if (spatial->ids[i] > 0) map.T_map_vehicle.push_back(spatial->graph.poses[i]);
  }
  if (map.T_map_vehicle.size() != map.drive.keyframes.size()) {
    return fail("not as many poses as keyframes", graph_file);
  }
  return map;
}

}  // namespace infuse::daemon
