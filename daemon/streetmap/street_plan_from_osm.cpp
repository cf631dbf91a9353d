#include "daemon/streetmap/street_plan_from_osm.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_map>

#include "drivers/gnss/local_frame.hpp"
#include "drivers/measurement/median.hpp"

namespace infuse::daemon {
namespace {

using osm::find_tag;
using streetmap::Polyline;
using streetmap::SegmentKind;

constexpr double kKerbWidth = 0.4;           // m, boundary line outside the carriageway
constexpr double kWallWidth = 0.8;           // m, boundary line on the outline of a building
constexpr double kSidewalkWidth = 2.4;       // m, pavement of a street with a sidewalk tag
constexpr double kCrossingHalfLength = 2.0;  // m, half the length of a crossing along the street
constexpr double kMaxDistance = 50e3;        // m from the median of the map
constexpr double kBeyondBounds = 100;        // m that are drawn outside the bounds of a file
constexpr double kCoastReach = 200;          // m of water that a coastline draws
constexpr size_t kMaxWarnings = 1000;

/// Defaults of a class of way.
struct WayDefaults {
  std::string_view highway;
  bool carriageway;
  double width;         // m, two-way without lanes stated
  double oneway_width;  // m, one-way without lanes stated
  double lane_width;    // m per lane, if lanes are stated
};
constexpr WayDefaults kWayDefaults[] = {
    {"motorway", true, 12.0, 12.0, 3.75},   {"motorway_link", true, 8.0, 6.0, 4.5},
    {"trunk", true, 8.0, 8.0, 3.5},         {"trunk_link", true, 7.5, 5.5, 4.5},
    {"primary", true, 7.5, 7.0, 3.5},       {"primary_link", true, 7.0, 5.0, 4.0},
    {"secondary", true, 7.0, 6.5, 3.5},     {"secondary_link", true, 6.5, 5.0, 4.0},
    {"tertiary", true, 6.5, 6.0, 3.25},     {"tertiary_link", true, 6.5, 5.0, 4.0},
    {"unclassified", true, 6.0, 5.5, 3.0},  {"residential", true, 6.0, 5.5, 3.0},
    {"living_street", true, 5.0, 5.0, 3.0}, {"road", true, 6.0, 5.0, 3.0},
    {"service", true, 4.0, 4.0, 3.0},       {"track", true, 3.0, 3.0, 3.0},
    {"pedestrian", false, 6.0, 6.0, 3.0},   {"footway", false, 2.0, 2.0, 2.0},
    {"cycleway", false, 2.2, 2.2, 2.0},     {"path", false, 1.6, 1.6, 1.6},
    {"steps", false, 2.0, 2.0, 2.0},        {"bridleway", false, 2.0, 2.0, 2.0},
};

const WayDefaults* find_way_defaults(std::string_view highway) {
  for (const WayDefaults& usual : kWayDefaults) {
    if (usual.highway == highway) return &usual;
  }
  return nullptr;
}

double street_width(const std::vector<osm::Tag>& tags, const WayDefaults& usual) {
  if (const auto width = osm::find_length(tags, "width", 0.8, 60)) return *width;
  if (const auto lanes = osm::find_number(tags, "lanes", 1, 12); lanes && usual.carriageway) {
    return std::max(3.5, *lanes * usual.lane_width);
  }
  const std::string_view oneway = find_tag(tags, "oneway");
  const bool one = oneway == "yes" || oneway == "1" || oneway == "-1" || oneway == "true" ||
                   find_tag(tags, "junction") == "roundabout";
  return one ? usual.oneway_width : usual.width;
}

// Pavements are drawn only where the map states them: a guessed pavement that does not exist, or is
// wider on one side, biases the lateral position.
bool has_sidewalk(const std::vector<osm::Tag>& tags, std::string_view side) {
  for (const std::string_view where : {side, std::string_view("both")}) {
    const std::string_view own = find_tag(tags, "sidewalk:" + std::string(where));
    if (!own.empty()) return own == "yes";
  }
  const std::string_view sidewalk = find_tag(tags, "sidewalk");
  return sidewalk == "both" || sidewalk == "yes" || sidewalk == side;
}

/// Level of a street: its layer, or 1, if it is a bridge; that of a cutting; else 0.
int street_layer(const std::vector<osm::Tag>& tags) {
  const auto layer = osm::find_number(tags, "layer", -10, 10);
  const std::string_view bridge = find_tag(tags, "bridge");
  if (!bridge.empty() && bridge != "no") return static_cast<int>(std::lround(layer.value_or(1)));
  return std::min(static_cast<int>(std::lround(layer.value_or(0))), 0);
}

std::optional<SegmentKind> area_kind(const std::vector<osm::Tag>& tags) {
  const auto tag = [&](std::string_view key) { return find_tag(tags, key); };
  const auto one_of = [](std::string_view value, std::initializer_list<std::string_view> list) {
    return std::find(list.begin(), list.end(), value) != list.end();
  };
  if (!tag("building").empty() && tag("building") != "no") return SegmentKind::kBuilding;
  if (tag("natural") == "water" || one_of(tag("waterway"), {"riverbank", "dock"}) ||
      one_of(tag("landuse"), {"reservoir", "basin"}) || tag("amenity") == "swimming_pool") {
    return SegmentKind::kWater;
  }
  if (one_of(tag("leisure"), {"park", "garden", "pitch", "playground", "golf_course"}) ||
      one_of(tag("landuse"), {"grass", "meadow", "forest", "village_green", "recreation_ground",
                              "allotments", "cemetery", "farmland", "orchard"}) ||
      one_of(tag("natural"), {"wood", "scrub", "grass", "grassland", "heath"})) {
    return SegmentKind::kGreen;
  }
  if (tag("amenity") == "parking" || tag("place") == "square") return SegmentKind::kPaved;
  if (!tag("highway").empty() && tag("area") == "yes") return SegmentKind::kPaved;
  return std::nullopt;
}

class StreetPlanBuilder {
 public:
  /// Uses all that the map holds.
  explicit StreetPlanBuilder(const osm::OpenStreetMap& map)
      : map_(map), frame_(gnss::make_local_frame(map.centre_latitude, map.centre_longitude)) {
    set_origin();
  }

  /// Uses what lies within `limit` and `beyond` metres around it, and its middle as the origin.
  StreetPlanBuilder(const osm::OpenStreetMap& map, const osm::Bounds& limit, double beyond)
      : map_(map),
        latitude_((limit.south + limit.north) / 2),
        longitude_((limit.west + limit.east) / 2),
        frame_(gnss::make_local_frame(latitude_, longitude_)),
        median_(latitude_, longitude_) {
    set_limit(limit, beyond);
  }

  OsmStreetPlan run() {
    planned_.plan.latitude = latitude_;
    planned_.plan.longitude = longitude_;
    planned_.warnings = map_.warnings;
    for (const osm::Way& way : map_.ways) add_way(way);
    for (const osm::Area& area : map_.areas) add_relation(area);
    for (const osm::Node& node : map_.nodes) add_crossing(node);
    return std::move(planned_);
  }

 private:
  // The middle of the bounding box, or the median of the points if outliers shift the box.
  void set_origin() {
    std::vector<double> latitudes, longitudes;
    for (const osm::Way& way : map_.ways) {
      for (const osm::Point& point : way.points) {
        latitudes.push_back(point.latitude);
        longitudes.push_back(point.longitude);
      }
    }
    latitude_ = map_.centre_latitude;
    longitude_ = map_.centre_longitude;
    if (latitudes.empty()) return;
    median_ = {median(latitudes), median(longitudes)};
    const auto [south, north] = std::minmax_element(latitudes.begin(), latitudes.end());
    const auto [west, east] = std::minmax_element(longitudes.begin(), longitudes.end());
    if (!is_beyond_limit(*south, *west) && !is_beyond_limit(*north, *east)) return;
    latitude_ = median_.x();
    longitude_ = median_.y();
    frame_ = gnss::make_local_frame(latitude_, longitude_);
  }

  bool is_beyond_limit(double latitude, double longitude) const {
    constexpr double kEarthRadius = 6.37e6;
    const double north = (latitude - median_.x()) * kEarthRadius;
    const double east =
        std::remainder(longitude - median_.y(), 2 * M_PI) * kEarthRadius * std::cos(median_.x());
    return std::hypot(north, east) > kMaxDistance;
  }

  /// `beyond`: m around the bounds that are used too.
  void set_limit(const osm::Bounds& bounds, double beyond) {
    Eigen::AlignedBox2d& limit = planned_.plan.limit;
    limit.setEmpty();
    for (const double latitude : {bounds.south, bounds.north}) {
      for (const double longitude : {bounds.west, bounds.east}) {
        limit.extend(gnss::to_local(frame_, latitude, longitude).head<2>());
      }
    }
    limit.min().array() -= beyond;
    limit.max().array() += beyond;
  }

  bool is_outside(const Polyline& line) const {
    const Eigen::AlignedBox2d& limit = planned_.plan.limit;
    if (limit.isEmpty()) return false;
    Eigen::AlignedBox2d box;
    for (const Eigen::Vector2d& point : line) box.extend(point);
    return !limit.intersects(box);
  }

  void warn(const char* kind, int64_t id, const char* what, const char* hint) {
    if (planned_.warnings.size() >= kMaxWarnings) return;
    planned_.warnings.push_back({what, std::string(kind) + " " + std::to_string(id), hint});
  }

  bool warn_if_far(const char* kind, int64_t id, const std::vector<osm::Point>& points) {
    for (const osm::Point& point : points) {
      if (!is_beyond_limit(point.latitude, point.longitude)) continue;
      warn(kind, id, "lies more than 50 km from the rest of the map", "it is skipped");
      return true;
    }
    return false;
  }

  Polyline to_polyline(const std::vector<osm::Point>& points) const {
    Polyline line;
    for (const osm::Point& point : points) {
      line.push_back(gnss::to_local(frame_, point.latitude, point.longitude).head<2>());
    }
    return line;
  }

  Polyline to_ring(const std::vector<osm::Point>& points) const {
    Polyline ring = to_polyline(points);
    ring.pop_back();
    std::erase_if(ring, [previous = ring.back()](const Eigen::Vector2d& point) mutable {
      return point == std::exchange(previous, point);
    });
    return ring;
  }

  void add_way(const osm::Way& way) {
    const auto kind = area_kind(way.tags);
    const std::string_view highway = find_tag(way.tags, "highway");
    const bool coast = find_tag(way.tags, "natural") == "coastline";
    if (!kind && !coast && highway.empty()) return;
    if (is_outside(to_polyline(way.points))) return;
    if (warn_if_far("way", way.id, way.points)) return;
    if (coast) {
      planned_.plan.strips.push_back(
          {{SegmentKind::kWater, way.id}, to_polyline(way.points), kCoastReach});
    }
    if (!kind) return add_street(way, highway);
    if (!way.closed()) {
      if (highway.empty()) warn("way", way.id, "is an area that does not close", "it is skipped");
      return;
    }
    add_ring("way", way.id, {{*kind, way.id}, {to_ring(way.points)}, wall_width(*kind)});
  }

  void add_relation(const osm::Area& area) {
    const auto kind = area_kind(area.tags);
    if (!kind) return;
    streetmap::PlanArea plan_area{{*kind, area.id}, {}, wall_width(*kind)};
    for (const auto* rings : {&area.outer, &area.inner}) {
      for (const auto& ring : *rings) {
        if (is_outside(to_polyline(ring))) continue;
        if (warn_if_far("relation", area.id, ring)) return;
        plan_area.rings.push_back(to_ring(ring));
      }
    }
    if (!plan_area.rings.empty()) add_ring("relation", area.id, std::move(plan_area));
  }

  static double wall_width(SegmentKind kind) {
    return kind == SegmentKind::kBuilding ? kWallWidth : 0;
  }

  void add_ring(const char* kind, int64_t id, streetmap::PlanArea area) {
    for (const Polyline& ring : area.rings) {
      if (!streetmap::crosses_itself(ring)) continue;
      return warn(kind, id, "has a ring that crosses itself", "it is skipped");
    }
    planned_.plan.areas.push_back(std::move(area));
  }

  void add_street(const osm::Way& way, std::string_view highway) {
    const WayDefaults* defaults = find_way_defaults(highway);
    const std::string_view tunnel = find_tag(way.tags, "tunnel");
    const bool is_tunnel = !tunnel.empty() && tunnel != "no";
    if (defaults == nullptr || (is_tunnel && !defaults->carriageway)) return;
    streetmap::PlanStrip strip;
    strip.segment = {defaults->carriageway ? SegmentKind::kCarriageway : SegmentKind::kFootway,
                     way.id};
    if (find_tag(way.tags, "footway") == "crossing") strip.segment.kind = SegmentKind::kCrossing;
    strip.points = to_polyline(way.points);
    strip.half_width = street_width(way.tags, *defaults) / 2;
    if (defaults->carriageway) {
      strip.kerb_width = kKerbWidth;
      strip.left_sidewalk_width = has_sidewalk(way.tags, "left") ? kSidewalkWidth : 0;
      strip.right_sidewalk_width = has_sidewalk(way.tags, "right") ? kSidewalkWidth : 0;
      strip.layer = street_layer(way.tags);
      strip.tunnel = is_tunnel;
    }
    if (defaults->carriageway && !is_tunnel) {
      for (size_t i = 0; i < way.points.size(); ++i) {
        streets_[way.points[i].node] = {planned_.plan.strips.size(), i};
      }
      ++planned_.carriageway_count;
    }
    planned_.plan.strips.push_back(std::move(strip));
  }

  /// Adds a crossing node of a street as a short strip of the same width.
  void add_crossing(const osm::Node& node) {
    if (find_tag(node.tags, "highway") != "crossing") return;
    const auto at = streets_.find(node.id);
    if (at == streets_.end()) return;
    const auto [index, point] = at->second;
    const streetmap::PlanStrip& street = planned_.plan.strips[index];
    const Eigen::Vector2d before = street.points[point > 0 ? point - 1 : 0];
    const Eigen::Vector2d after = street.points[std::min(point + 1, street.points.size() - 1)];
    const Eigen::Vector2d along = (after - before).normalized();
    if (!along.allFinite()) return;
    const Eigen::Vector2d across(-along.y(), along.x());
    const Eigen::Vector2d middle = street.points[point];
    planned_.plan.strips.push_back(
        {{SegmentKind::kCrossing, node.id},
         {middle - street.half_width * across, middle + street.half_width * across},
         kCrossingHalfLength});
  }

  const osm::OpenStreetMap& map_;
  double latitude_ = 0, longitude_ = 0;
  gnss::LocalFrame frame_;
  Eigen::Vector2d median_{0, 0};
  OsmStreetPlan planned_;
  std::unordered_map<int64_t, std::pair<size_t, size_t>> streets_;  // strip and point by node
};

}  // namespace

OsmStreetPlan build_street_plan(const osm::OpenStreetMap& map,
                                const std::optional<osm::Bounds>& clip) {
  if (clip) return StreetPlanBuilder(map, *clip, 0).run();
  if (!map.bounds) return StreetPlanBuilder(map).run();
  OsmStreetPlan planned = StreetPlanBuilder(map, *map.bounds, kBeyondBounds).run();
  if (planned.carriageway_count > 0) return planned;
  planned = StreetPlanBuilder(map).run();
  planned.warnings.push_back({"has no road within its bounds", "", "the bounds are not used"});
  return planned;
}

}  // namespace infuse::daemon
