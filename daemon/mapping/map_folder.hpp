#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/mapping/map_tables.hpp"
#include "drivers/host/file_descriptor.hpp"
#include "fusion/mapping/pose_graph.hpp"
#include "fusion/mapping/submap.hpp"

namespace infuse::daemon {

using MapJson = nlohmann::ordered_json;

/// Names of the files of a map folder.
namespace map_file {
inline constexpr const char* kDrive = "drive.json";  ///< the replay is complete
inline constexpr const char* kKeyframes = "keyframes.csv";
inline constexpr const char* kFixes = "fixes.csv";
inline constexpr const char* kPlaces = "places.bin";
inline constexpr const char* kClosures = "closures.csv";                 ///< sought so far
inline constexpr const char* kEarlierClosures = "earlier_closures.csv";  ///< of merged maps
inline constexpr const char* kGraph = "graph.g2o";
inline constexpr const char* kTrajectory = "trajectory";  ///< see `trajectory_name`
inline constexpr const char* kMap = "map.json";           ///< the map is complete
inline constexpr const char* kClouds = "clouds";          ///< folder
}  // namespace map_file

/// Key of a manifest: the first keyframe of each drive of a merged map.
inline constexpr const char* kFirstKeyframes = "first_keyframes";
/// Key of a complete map's manifest: the keyframes that keep their clouds; all without it.
inline constexpr const char* kKeptClouds = "clouds";

/// A map folder on disk. Every file is written atomically.
class MapFolder {
 public:
  explicit MapFolder(std::filesystem::path path) : path_(std::move(path)), opened_(path_) {}

  /// The folder that has the path at present: its files are read even where another folder takes
  /// the path later. Fails if it cannot be opened.
  Result<MapFolder> hold() const;

  /// Tells two folders of one path apart while both are held.
  struct Id {
    uint64_t device = 0, inode = 0;  ///< 0: there is no folder
    bool operator==(const Id&) const = default;
  };
  Id id() const;

  const std::filesystem::path& path() const { return path_; }
  std::string path_of(const std::string& name) const { return (path_ / name).string(); }
  bool has(const std::string& name) const;

  /// Creates the folder. Fails if it exists and holds files that no map has, or if its clouds'
  /// folder does and there is no map.
  Result<void> create() const;

  Result<void> write(const std::string& name, std::string_view bytes) const;
  /// Reads a file of at most 256 MiB; if a checksum is given, fails where the file has another.
  Result<std::string> read(const std::string& name, const std::string& checksum = "") const;

  /// Reads drive.json or map.json. Fails if it is not the manifest of a map of this version.
  Result<MapJson> read_manifest(const std::string& name) const;
  /// True if drive.json is there: what the map is made of is complete. Fails if it is not of
  /// `identity`, of which every key and value must be the same.
  Result<bool> is_made_of(const MapJson& identity) const;
  /// Reads a file with the checksum that a manifest states.
  Result<std::string> read_stated(const MapJson& manifest, const std::string& name) const;

  /// Removes the clouds of all other keyframes; files of other names are left.
  void keep_clouds(const std::vector<size_t>& kept) const;
  /// Removes what was found of earlier content: closures.csv and map.json.
  void remove_results() const;

  static std::string cloud_name(size_t keyframe);
  /// trajectory.tum of the first drive, trajectory_2.tum of the second …
  static std::string trajectory_name(size_t drive);
  /// Writes the cloud of a keyframe; returns its checksum.
  Result<std::string> write_cloud(size_t keyframe, const mapping::Submap& cloud) const;
  Result<mapping::Submap> read_cloud(const std::vector<MapKeyframe>& keyframes, size_t k) const;

 private:
  std::filesystem::path path_;    // as it is named
  std::filesystem::path opened_;  // where it is read
  std::shared_ptr<const host::FileDescriptor> held_;
};

/// A manifest with format and version.
MapJson make_manifest();

/// What the replay of a drive left.
struct MapDrive {
  MapJson manifest;
  Eigen::Isometry3d T_vehicle_lidar = Eigen::Isometry3d::Identity();
  std::vector<MapKeyframe> keyframes;
  std::vector<size_t> first_keyframes{0};  ///< of each drive of a merged map
  std::vector<mapping::Closure> closures;  ///< of the maps that were merged, in order of `to`
  std::vector<MapFix> fixes;
};

/// Reads drive.json and its tables. An error names the file that is damaged or missing.
Result<MapDrive> read_map_drive(const MapFolder& folder);

/// A complete map.
struct MapContent {
  MapJson manifest;
  MapDrive drive;
  std::vector<Eigen::Isometry3d> T_map_vehicle;  ///< by keyframe
};

/// Reads a complete map, without its clouds. Fails if it is not complete or a file is damaged.
Result<MapContent> read_map(const MapFolder& folder);

}  // namespace infuse::daemon
