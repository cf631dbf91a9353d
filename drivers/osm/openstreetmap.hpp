#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/measurement/error.hpp"

namespace infuse::osm {

/// A tag of an OpenStreetMap element.
struct Tag {
  std::string key;
  std::string value;
};

/// A node with tags (a tree, a sign, a crossing).
struct Node {
  int64_t id = 0;
  double latitude = 0;   ///< rad, WGS 84
  double longitude = 0;  ///< rad
  std::vector<Tag> tags;
};

/// A point of a way.
struct Point {
  int64_t node = 0;      ///< id; ways with a common node are connected there
  double latitude = 0;   ///< rad, WGS 84
  double longitude = 0;  ///< rad
};

/// A polyline: a road, a footway, a wall, the outline of a building.
struct Way {
  int64_t id = 0;
  std::vector<Tag> tags;
  std::vector<Point> points;  ///< at least two; nodes that are not in the file are left out

  /// True if the first and the last point are the same node.
  bool closed() const { return points.size() > 3 && points.front().node == points.back().node; }
};

/// A multipolygon relation. Its rings are closed: the first point is repeated at the end.
struct Area {
  int64_t id = 0;
  std::vector<Tag> tags;
  std::vector<std::vector<Point>> outer;
  std::vector<std::vector<Point>> inner;  ///< holes
};

/// Latitudes and longitudes, rad, WGS 84.
struct Bounds {
  double south = 0, west = 0, north = 0, east = 0;
};

/// Elements of an OpenStreetMap file, in file order.
struct OpenStreetMap {
  std::vector<Node> nodes;  ///< only those with tags
  std::vector<Way> ways;
  std::vector<Area> areas;
  double centre_latitude = 0;    ///< rad; centre of the bounding box of all ways
  double centre_longitude = 0;   ///< rad
  std::optional<Bounds> bounds;  ///< of the extract, if the file states them; ways may reach beyond
  /// Problems with the id of the element: missing nodes, rings that do not close, a map without
  /// roads. At most 1000, and one that states the number of further ones.
  std::vector<Error> warnings;
};

/// Returns the value of a key, or an empty string.
std::string_view find_tag(const std::vector<Tag>& tags, std::string_view key);

/// Returns the leading number of a key's value; nothing if there is none or it is not within the
/// limits.
std::optional<double> find_number(const std::vector<Tag>& tags, std::string_view key, double low,
                                  double high);

/// Returns the length of a key's value in metres: a number with a decimal point or comma, and no
/// unit or m, cm, km, ft, feet, ' (and inches) behind it. Nothing for another text, or beyond the
/// limits.
std::optional<double> find_length(const std::vector<Tag>& tags, std::string_view key, double low,
                                  double high);

/// Limits for reading a map.
struct OpenStreetMapOptions {
  uint64_t max_elements = 20'000'000;  ///< maximum of nodes + ways + relations + tags + references
};

/// Reads OpenStreetMap XML (.osm, .osm.bz2, .osm.gz) or its binary form (.osm.pbf). Fails if the
/// file cannot be read or parsed. Incomplete elements become warnings.
Result<OpenStreetMap> read_openstreetmap(const std::filesystem::path& path,
                                         const OpenStreetMapOptions& options = {});

}  // namespace infuse::osm
