#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/measurement/error.hpp"

namespace infuse::recording {

/// One key and value of an OpenStreetMap element.
struct OsmTag {
  std::string key;
  std::string value;
};

/// A node that stands for something by itself (a tree, a sign, a crossing): it has tags.
struct OsmNode {
  int64_t id = 0;
  double latitude = 0;   ///< rad, WGS 84
  double longitude = 0;  ///< rad
  std::vector<OsmTag> tags;
};

/// A corner of a way.
struct OsmPoint {
  int64_t node = 0;      ///< id; two ways that share a node are joined there
  double latitude = 0;   ///< rad, WGS 84
  double longitude = 0;  ///< rad
};

/// A polyline: a road, a footway, a wall, the outline of a building.
struct OsmWay {
  int64_t id = 0;
  std::vector<OsmTag> tags;
  std::vector<OsmPoint> points;  ///< at least two; those whose node the file lacks are left out

  /// Whether it ends where it begins.
  bool closed() const { return points.size() > 3 && points.front().node == points.back().node; }
};

/// A multipolygon relation: rings, closed, the first point repeated at the end.
struct OsmArea {
  int64_t id = 0;
  std::vector<OsmTag> tags;
  std::vector<std::vector<OsmPoint>> outer;
  std::vector<std::vector<OsmPoint>> inner;  ///< holes
};

/// A street map as OpenStreetMap describes it. Elements are in the order of the file.
struct OpenStreetMap {
  std::vector<OsmNode> nodes;  ///< such as have tags
  std::vector<OsmWay> ways;
  std::vector<OsmArea> areas;
  double centre_latitude = 0;   ///< rad; middle of the box around all points of ways
  double centre_longitude = 0;  ///< rad
  /// What is not as it should be, each with the element's id: missing nodes, rings that do not
  /// close, no road at all. The first 1000; the last one then says how many more there are.
  std::vector<Error> warnings;
};

/// The value of a key, or empty.
std::string_view find_tag(const std::vector<OsmTag>& tags, std::string_view key);

/// How much a map may hold.
struct OpenStreetMapOptions {
  uint64_t max_elements = 20'000'000;  ///< nodes + ways + relations + references between them
};

/// Reads OpenStreetMap XML (.osm, .osm.bz2, .osm.gz). Fails where the file cannot be read or
/// parsed; what is merely incomplete becomes a warning.
Result<OpenStreetMap> read_openstreetmap(const std::filesystem::path& path,
                                         const OpenStreetMapOptions& options = {});

}  // namespace infuse::recording
