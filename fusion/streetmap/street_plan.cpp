#include "fusion/streetmap/street_plan.hpp"

#include <algorithm>

namespace infuse::streetmap {
namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

double side(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& point) {
  return cross(b - a, point - a);
}

/// True if a point on the line through a and b lies between them.
bool within(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& point) {
  return (point.array() >= a.array().min(b.array())).all() &&
         (point.array() <= a.array().max(b.array())).all();
}

bool segments_intersect(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                        const Eigen::Vector2d& c, const Eigen::Vector2d& d) {
  const double ac = side(c, d, a), bc = side(c, d, b), ca = side(a, b, c), da = side(a, b, d);
  if (ac * bc < 0 && ca * da < 0) return true;
  return (ac == 0 && within(c, d, a)) || (bc == 0 && within(c, d, b)) ||
         (ca == 0 && within(a, b, c)) || (da == 0 && within(a, b, d));
}

}  // namespace

double signed_area(const Polyline& ring) {
  double twice = 0;
  for (size_t i = 0; i < ring.size(); ++i) twice += cross(ring[i], ring[(i + 1) % ring.size()]);
  return twice / 2;
}

bool crosses_itself(const Polyline& ring) {
  const size_t n = ring.size();
  if (n < 4) return false;
  // Edges sorted by their western ends: only edges that overlap in x are compared.
  struct Edge {
    double west, east;
    size_t index;
  };
  std::vector<Edge> edges;
  for (size_t i = 0; i < n; ++i) {
    const auto [west, east] = std::minmax(ring[i].x(), ring[(i + 1) % n].x());
    edges.push_back({west, east, i});
  }
  std::sort(edges.begin(), edges.end(),
            [](const Edge& a, const Edge& b) { return a.west < b.west; });
  for (size_t i = 0; i < n; ++i) {
    for (size_t k = i + 1; k < n && edges[k].west <= edges[i].east; ++k) {
      const size_t a = edges[i].index, b = edges[k].index;
      if ((a + 1) % n == b || (b + 1) % n == a) continue;
      if (segments_intersect(ring[a], ring[(a + 1) % n], ring[b], ring[(b + 1) % n])) return true;
    }
  }
  return false;
}

}  // namespace infuse::streetmap
