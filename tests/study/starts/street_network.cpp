#include "tests/study/starts/street_network.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "drivers/measurement/angles.hpp"

namespace infuse::study {
namespace {

constexpr double kMinHalfWidth = 2.4;  // m; narrower: driveways and tracks
constexpr double kWorldSigma = 0.8;    // m per axis, of the points of the world against the map
constexpr double kMaxCorner = 2.6;     // rad; sharper is turning back
constexpr int kTries = 400;            // until a walk is long enough

void remove_dead_ends(StreetNetwork& network) {
  std::vector<int> ends;
  for (size_t i = 0; i < network.joined.size(); ++i) {
    if (network.joined[i].size() == 1) ends.push_back(static_cast<int>(i));
  }
  while (!ends.empty()) {
    const int end = ends.back();
    ends.pop_back();
    auto& own = network.joined[static_cast<size_t>(end)];
    if (own.size() != 1) continue;
    auto& other = network.joined[static_cast<size_t>(own[0])];
    std::erase(other, end);
    if (other.size() == 1) ends.push_back(own[0]);
    own.clear();
  }
}

/// Points of the network along a walk; ends where it would have to turn back.
std::vector<int> draw_points(const StreetNetwork& network, std::mt19937_64& random, double length) {
  std::vector<int> walk;
  const auto at = [&](int i) { return network.points[static_cast<size_t>(i)]; };
  int last = static_cast<int>(random() % network.points.size());
  if (network.joined[static_cast<size_t>(last)].empty()) return walk;
  walk.push_back(last);
  for (double driven = 0; driven < length;) {
    std::vector<int> ways;
    for (const int next : network.joined[static_cast<size_t>(walk.back())]) {
      if (walk.size() > 1) {
        const Eigen::Vector2d before = at(walk.back()) - at(walk[walk.size() - 2]);
        const Eigen::Vector2d after = at(next) - at(walk.back());
        const double corner =
            std::atan2(before.x() * after.y() - before.y() * after.x(), before.dot(after));
        if (std::abs(corner) > kMaxCorner) continue;
      }
      ways.push_back(next);
    }
    if (ways.empty()) break;
    walk.push_back(ways[random() % ways.size()]);
    driven += (at(walk.back()) - at(walk[walk.size() - 2])).norm();
  }
  return walk;
}

}  // namespace

StreetNetwork network_of(const streetmap::StreetPlan& plan) {
  StreetNetwork network;
  std::map<std::pair<int64_t, int64_t>, int> index;
  const auto point = [&](const Eigen::Vector2d& p) {
    const std::pair key(std::llround(100 * p.x()), std::llround(100 * p.y()));
    const auto [found, is_new] = index.try_emplace(key, static_cast<int>(network.points.size()));
    if (is_new) {
      network.points.push_back(p);
      network.joined.emplace_back();
    }
    return found->second;
  };
  const auto join = [&](int from, int to) {
    auto& list = network.joined[static_cast<size_t>(from)];
    if (from != to && std::find(list.begin(), list.end(), to) == list.end()) list.push_back(to);
  };
  for (const streetmap::PlanStrip& strip : plan.strips) {
    if (strip.segment.kind != streetmap::SegmentKind::kCarriageway ||
        strip.half_width < kMinHalfWidth) {
      continue;
    }
    for (size_t i = 1; i < strip.points.size(); ++i) {
      const int from = point(strip.points[i - 1]), to = point(strip.points[i]);
      join(from, to);
      join(to, from);
    }
  }
  remove_dead_ends(network);
  return network;
}

std::vector<Eigen::Vector2d> crossings(const StreetNetwork& network) {
  std::vector<Eigen::Vector2d> result;
  for (size_t i = 0; i < network.points.size(); ++i) {
    if (network.joined[i].size() > 2) result.push_back(network.points[i]);
  }
  return result;
}

PlanarDrive draw_drive(const StreetNetwork& network, uint64_t seed, double length) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<Eigen::Vector2d> world = network.points;
  for (Eigen::Vector2d& p : world)
    p += kWorldSigma * Eigen::Vector2d(normal(random), normal(random));
  streetmap::Polyline longest;
  double reached = 0;
  for (int i = 0; i < kTries && reached < length && !network.points.empty(); ++i) {
    streetmap::Polyline line;
    double driven = 0;
    for (const int p : draw_points(network, random, length)) {
      line.push_back(world[static_cast<size_t>(p)]);
      if (line.size() > 1) driven += (line.back() - line[line.size() - 2]).norm();
    }
    if (driven <= reached) continue;
    reached = driven;
    longest = line;
  }
  return drive_on_right(longest);
}

}  // namespace infuse::study
