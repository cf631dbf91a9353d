#include "drivers/osm/openstreetmap.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <osmium/io/bzip2_compression.hpp>
#include <osmium/io/gzip_compression.hpp>
#include <osmium/io/pbf_input.hpp>
#include <osmium/io/reader.hpp>
#include <osmium/io/xml_input.hpp>
#include <osmium/osm/node.hpp>
#include <osmium/osm/relation.hpp>
#include <osmium/osm/way.hpp>
#include <unordered_map>

#include "drivers/measurement/angles.hpp"
#include "drivers/osm/osm_rings.hpp"

namespace infuse::osm {
namespace {

constexpr size_t kMaxWarnings = 1000;

struct Member {
  int64_t way = 0;
  bool inner = false;
};

struct Relation {
  int64_t id = 0;
  std::vector<Tag> tags;
  std::vector<Member> members;
};

// The list is texts that end with NUL, key and value in turn. A binary map may have a NUL in a
// text: libosmium's own iterator then leaves the list.
std::vector<Tag> copy_tags(const osmium::OSMObject& object) {
  const osmium::TagList& list = object.tags();
  std::string_view rest(reinterpret_cast<const char*>(list.data()), list.byte_size());
  rest.remove_prefix(std::min(sizeof(osmium::TagList), rest.size()));
  std::vector<Tag> tags;
  while (true) {
    const size_t key = rest.find('\0');
    if (key == std::string_view::npos) return tags;
    const size_t value = rest.find('\0', key + 1);
    if (value == std::string_view::npos) return tags;
    tags.push_back(
        {std::string(rest.substr(0, key)), std::string(rest.substr(key + 1, value - key - 1))});
    rest.remove_prefix(value + 1);
  }
}

// Collects the elements of a file in any order, then resolves their references.
class MapBuilder {
 public:
  explicit MapBuilder(const OpenStreetMapOptions& options) : options_(options) {}

  void set_bounds(const osmium::Box& box) {
    if (!box.valid()) return;
    map_.bounds = {box.bottom_left().lat() * kDegree, box.bottom_left().lon() * kDegree,
                   box.top_right().lat() * kDegree, box.top_right().lon() * kDegree};
  }

  // Returns false if the file exceeds the limit of the options.
  bool add(const osmium::OSMEntity& entity) {
    switch (entity.type()) {
      case osmium::item_type::node:
        add_node(static_cast<const osmium::Node&>(entity));
        break;
      case osmium::item_type::way:
        add_way(static_cast<const osmium::Way&>(entity));
        break;
      case osmium::item_type::relation:
        add_relation(static_cast<const osmium::Relation&>(entity));
        break;
      default:
        break;
    }
    return elements_ <= options_.max_elements;
  }

  OpenStreetMap finish() {
    resolve_ways();
    for (Relation& relation : relations_) resolve_relation(relation);
    set_centre();
    const bool roads = std::any_of(map_.ways.begin(), map_.ways.end(), [](const Way& way) {
      return !find_tag(way.tags, "highway").empty();
    });
    if (!roads) warn("", 0, "the map has no road", "no way has the key highway");
    if (dropped_warnings_ > 0) {
      map_.warnings.push_back({std::to_string(dropped_warnings_) + " more warnings", {}, {}});
    }
    return std::move(map_);
  }

 private:
  void add_node(const osmium::Node& node) {
    std::vector<Tag> tags = copy_tags(node);
    elements_ += 1 + tags.size();
    // Beyond 180°, so that a map across that meridian has no gap: as far as the format holds it.
    const osmium::Location at = node.location();
    if (!at.is_defined() || std::abs(at.lat_without_check()) > 90) {
      return warn("node", node.id(), "has no valid latitude and longitude", "it is ignored");
    }
    const Point point{node.id(), at.lat_without_check() * kDegree,
                      at.lon_without_check() * kDegree};
    points_[node.id()] = point;
    if (tags.empty()) return;
    map_.nodes.push_back({node.id(), point.latitude, point.longitude, std::move(tags)});
  }

  // Points contain only node ids until all nodes are known.
  void add_way(const osmium::Way& way) {
    Way& added = map_.ways.emplace_back();
    added.id = way.id();
    added.tags = copy_tags(way);
    elements_ += 1 + added.tags.size() + way.nodes().size();
    for (const osmium::NodeRef& node : way.nodes()) added.points.push_back({node.ref(), 0, 0});
  }

  void add_relation(const osmium::Relation& relation) {
    std::vector<Tag> tags = copy_tags(relation);
    elements_ += 1 + tags.size() + relation.members().size();
    if (find_tag(tags, "type") != "multipolygon") return;
    Relation& added = relations_.emplace_back();
    added.id = relation.id();
    added.tags = std::move(tags);
    for (const osmium::RelationMember& member : relation.members()) {
      if (member.type() != osmium::item_type::way) continue;
      added.members.push_back({member.ref(), std::string_view(member.role()) == "inner"});
    }
  }

  void resolve_ways() {
    std::erase_if(map_.ways, [this](Way& way) {
      const size_t missing = std::erase_if(way.points, [this](Point& point) {
        const auto at = points_.find(point.node);
        if (at == points_.end()) return true;
        point = at->second;
        return false;
      });
      if (missing > 0) {
        warn("way", way.id, std::to_string(missing) + " of its nodes are not in the file",
             "they are ignored");
      }
      if (way.points.size() >= 2) return false;
      warn("way", way.id, "has fewer than two nodes", "it is ignored");
      return true;
    });
    for (size_t i = 0; i < map_.ways.size(); ++i) way_index_[map_.ways[i].id] = i;
  }

  void resolve_relation(Relation& relation) {
    std::vector<const Way*> outer, inner;
    for (const Member& member : relation.members) {
      const auto at = way_index_.find(member.way);
      if (at == way_index_.end()) {
        warn("relation", relation.id, "way " + std::to_string(member.way) + " is not in the file",
             {});
        continue;
      }
      (member.inner ? inner : outer).push_back(&map_.ways[at->second]);
    }
    Area area;
    area.id = relation.id;
    area.tags = std::move(relation.tags);
    const size_t open = join_rings(outer, area.outer) + join_rings(inner, area.inner);
    if (open > 0) {
      warn("relation", relation.id, std::to_string(open) + " of its rings do not close",
           "they are ignored");
    }
    if (area.outer.empty()) {
      return warn("relation", relation.id, "has no closed outer ring", "it is ignored");
    }
    map_.areas.push_back(std::move(area));
  }

  void set_centre() {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    double south = kInfinity, north = -kInfinity, west = kInfinity, east = -kInfinity;
    for (const Way& way : map_.ways) {
      for (const Point& point : way.points) {
        south = std::min(south, point.latitude);
        north = std::max(north, point.latitude);
        west = std::min(west, point.longitude);
        east = std::max(east, point.longitude);
      }
    }
    if (map_.ways.empty()) return;
    map_.centre_latitude = (south + north) / 2;
    map_.centre_longitude = (west + east) / 2;
  }

  void warn(const char* kind, int64_t id, std::string what, std::string hint) {
    if (map_.warnings.size() == kMaxWarnings) {
      ++dropped_warnings_;
      return;
    }
    std::string where = kind;
    if (!where.empty()) where.append(" ").append(std::to_string(id));
    map_.warnings.push_back({std::move(what), std::move(where), std::move(hint)});
  }

  OpenStreetMapOptions options_;
  OpenStreetMap map_;
  std::unordered_map<int64_t, Point> points_;
  std::unordered_map<int64_t, size_t> way_index_;
  std::vector<Relation> relations_;
  uint64_t elements_ = 0;
  uint64_t dropped_warnings_ = 0;
};

}  // namespace

std::string_view find_tag(const std::vector<Tag>& tags, std::string_view key) {
  const auto at =
      std::find_if(tags.begin(), tags.end(), [&](const Tag& tag) { return tag.key == key; });
  return at == tags.end() ? std::string_view() : std::string_view(at->value);
}

std::optional<double> find_number(const std::vector<Tag>& tags, std::string_view key, double low,
                                  double high) {
  const std::string_view text = find_tag(tags, key);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || !(value >= low && value <= high)) return std::nullopt;
  return value;
}

std::optional<double> find_length(const std::vector<Tag>& tags, std::string_view key, double low,
                                  double high) {
  struct Unit {
    std::string_view name;
    double metres;
  };
  constexpr double kFoot = 0.3048, kInch = 0.0254;
  constexpr Unit kUnits[] = {{"", 1},      {"m", 1},      {"metres", 1},   {"cm", 0.01},
                             {"km", 1000}, {"ft", kFoot}, {"feet", kFoot}, {"'", kFoot}};
  std::string text(find_tag(tags, key));
  std::erase(text, ' ');
  std::replace(text.begin(), text.end(), ',', '.');
  const char* const last = text.data() + text.size();
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), last, value);
  if (error != std::errc()) return std::nullopt;
  std::string_view rest(end, static_cast<size_t>(last - end));
  double inches = 0;
  if (rest.size() > 2 && rest.front() == '\'' && rest.back() == '"') {
    const char* const quote = last - 1;
    if (std::from_chars(end + 1, quote, inches).ptr != quote) return std::nullopt;
    rest = rest.substr(0, 1);
  }
  for (const Unit& unit : kUnits) {
    if (rest != unit.name) continue;
    const double metres = value * unit.metres + inches * kInch;
    return metres >= low && metres <= high ? std::optional(metres) : std::nullopt;
  }
  return std::nullopt;
}

Result<OpenStreetMap> read_openstreetmap(const std::filesystem::path& path,
                                         const OpenStreetMapOptions& options) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored))
    return fail("is not a regular file", path.string());
  // libosmium throws exceptions: system errors, XML errors with line and column, compression
  // errors.
  try {
    MapBuilder builder(options);
    osmium::io::Reader reader(path.string(), osmium::osm_entity_bits::nwr);
    builder.set_bounds(reader.header().joined_boxes());
    while (const osmium::memory::Buffer buffer = reader.read()) {
      for (const auto& entity : buffer.select<osmium::OSMEntity>()) {
        if (builder.add(entity)) continue;
        return fail("contains more than " + std::to_string(options.max_elements) + " elements",
                    path.string(), "extract a smaller area, for example with osmium extract");
      }
    }
    reader.close();
    return builder.finish();
  } catch (const std::exception& error) {
    return fail(std::string("cannot be read as OpenStreetMap data: ") + error.what(),
                path.string());
  }
}

}  // namespace infuse::osm
