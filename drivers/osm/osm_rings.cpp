#include "drivers/osm/osm_rings.hpp"

#include <unordered_map>

namespace infuse::osm {
namespace {

// Index of ways by their end nodes, including ways already used.
using WaysByEndNode = std::unordered_multimap<int64_t, size_t>;

// Returns an unused way that ends at `node`, or `used.size()`.
size_t find_unused(const WaysByEndNode& ends, int64_t node, const std::vector<bool>& used) {
  const auto [first, last] = ends.equal_range(node);
  for (auto at = first; at != last; ++at) {
    if (!used[at->second]) return at->second;
  }
  return used.size();
}

// Appends a way to a ring whose last point is an end of the way.
void append(const std::vector<Point>& way, std::vector<Point>& ring) {
  if (way.front().node == ring.back().node) {
    ring.insert(ring.end(), way.begin() + 1, way.end());
  } else {
    ring.insert(ring.end(), way.rbegin() + 1, way.rend());
  }
}

}  // namespace

size_t join_rings(const std::vector<const Way*>& ways, std::vector<std::vector<Point>>& rings) {
  WaysByEndNode ends;
  for (size_t i = 0; i < ways.size(); ++i) {
    ends.emplace(ways[i]->points.front().node, i);
    ends.emplace(ways[i]->points.back().node, i);
  }
  std::vector<bool> used(ways.size());
  size_t open = 0;
  for (size_t start = 0; start < ways.size(); ++start) {
    if (used[start]) continue;
    used[start] = true;
    std::vector<Point> ring = ways[start]->points;
    while (ring.back().node != ring.front().node) {
      const size_t next = find_unused(ends, ring.back().node, used);
      if (next == ways.size()) break;
      used[next] = true;
      append(ways[next]->points, ring);
    }
    if (ring.size() > 3 && ring.back().node == ring.front().node) {
      rings.push_back(std::move(ring));
    } else {
      ++open;
    }
  }
  return open;
}

}  // namespace infuse::osm
