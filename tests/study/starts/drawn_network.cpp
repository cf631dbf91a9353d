#include "tests/study/starts/drawn_network.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "drivers/measurement/angles.hpp"

namespace infuse::study {
namespace {

using streetmap::Polyline;

constexpr double kSpeed = 8;       // m/s
constexpr double kMapSigma = 0.8;  // m per axis, of the points of the map
constexpr double kLane = 1.2;      // m right of the middle
constexpr int kWalks = 200;        // until one does not end in a dead end

/// Crossings and the streets between them.
struct Network {
  struct Street {
    int from = 0, to = 0;
    Polyline points;
  };
  std::vector<Eigen::Vector2d> crossings;
  std::vector<Street> streets;
};

Network draw_network(std::mt19937_64& random, double edge) {
  std::uniform_real_distribution<double> share(-1, 1);
  const double spacing = 95 + 25 * share(random);
  const double irregular = 0.17 + 0.13 * share(random);  // of the spacing; small: blocks are alike
  const int n = static_cast<int>(edge / spacing) + 1;
  Network network;
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column < n; ++column) {
      network.crossings.emplace_back(spacing * (column + irregular * share(random)),
                                     spacing * (row + irregular * share(random)));
    }
  }
  const auto connect = [&](int from, int to) {
    if (share(random) < -0.5) return;  // every fourth street is missing
    const Eigen::Vector2d a = network.crossings[static_cast<size_t>(from)];
    const Eigen::Vector2d b = network.crossings[static_cast<size_t>(to)];
    const Eigen::Vector2d aside(-(b - a).y(), (b - a).x());
    const double bend = share(random) > 0 ? 0.12 * share(random) : 0;
    Polyline points;
    for (const double t : {0.0, 0.25, 0.5, 0.75, 1.0}) {
      points.push_back(a + t * (b - a) + 4 * t * (1 - t) * bend * aside);
    }
    network.streets.push_back({from, to, points});
  };
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column < n; ++column) {
      if (column + 1 < n) connect(row * n + column, row * n + column + 1);
      if (row + 1 < n) connect(row * n + column, (row + 1) * n + column);
    }
  }
  return network;
}

/// The middle of the streets along a walk without turning back; it may end in a dead end.
Polyline draw_walk(const Network& network, std::mt19937_64& random, double length) {
  Polyline walk;
  size_t last = random() % network.streets.size();
  int at = network.streets[last].from;
  for (double driven = 0; driven < length;) {
    std::vector<size_t> ways;
    for (size_t i = 0; i < network.streets.size(); ++i) {
      const Network::Street& street = network.streets[i];
      if ((street.from == at || street.to == at) && (i != last || walk.empty())) ways.push_back(i);
    }
    if (ways.empty()) break;
    last = ways[random() % ways.size()];
    Polyline points = network.streets[last].points;
    if (network.streets[last].to == at) std::reverse(points.begin(), points.end());
    at = network.streets[last].from == at ? network.streets[last].to : network.streets[last].from;
    for (const Eigen::Vector2d& p : points) {
      if (walk.empty()) walk.push_back(p);
      const double step = (p - walk.back()).norm();
      if (step < 0.5) continue;
      driven += step;
      walk.push_back(p);
    }
  }
  return walk;
}

Polyline resample(const Polyline& line, double step) {
  Polyline result;
  double next = 0, begin = 0;
  for (size_t i = 0; i + 1 < line.size(); ++i) {
    const double length = (line[i + 1] - line[i]).norm();
    for (; next <= begin + length; next += step) {
      result.push_back(line[i] + (next - begin) / std::max(length, 1e-9) * (line[i + 1] - line[i]));
    }
    begin += length;
  }
  return result;
}

Polyline smooth(const Polyline& line, int reach) {
  Polyline result;
  const int n = static_cast<int>(line.size());
  for (int i = 0; i < n; ++i) {
    const int half = std::min({reach, i, n - 1 - i});
    Eigen::Vector2d sum(0, 0);
    for (int k = i - half; k <= i + half; ++k) sum += line[static_cast<size_t>(k)];
    result.push_back(sum / (2 * half + 1));
  }
  return result;
}

double heading(const Polyline& line, size_t i) {
  const Eigen::Vector2d d = line[std::min(i + 1, line.size() - 1)] - line[i > 0 ? i - 1 : 0];
  return std::atan2(d.y(), d.x());
}

double length_of(const Polyline& line) {
  double length = 0;
  for (size_t i = 1; i < line.size(); ++i) length += (line[i] - line[i - 1]).norm();
  return length;
}

}  // namespace

PlanarDrive drive_on_right(const Polyline& middle) {
  const Polyline rounded = smooth(resample(middle, 0.5), 8);
  Polyline line = rounded;
  for (size_t i = 0; i < line.size(); ++i) {
    const double yaw = heading(rounded, i);
    line[i] += kLane * Eigen::Vector2d(std::sin(yaw), -std::cos(yaw));
  }
  return drive_along(smooth(line, 6));
}

PlanarDrive drive_along(const Polyline& line) {
  const Polyline fine = resample(line, 0.2);
  PlanarDrive drive;
  double next = 0;
  for (size_t i = 1; i + 1 < fine.size(); ++i) {
    if (static_cast<double>(i) * 0.2 < next) continue;
    drive.poses.push_back({fine[i].x(), fine[i].y(), heading(fine, i)});
    const double ahead = heading(fine, std::min(i + 25, fine.size() - 2));
    const double bend = std::abs(wrap_angle(ahead - drive.poses.back().yaw));
    next += drive.period * kSpeed / (1 + 2 * bend);
  }
  return drive;
}

DrawnTown draw_town(uint64_t seed, double edge, double length) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const Network network = draw_network(random, edge);
  DrawnTown town;
  int64_t id = 1;
  for (const Network::Street& street : network.streets) {
    Polyline points = street.points;
    for (Eigen::Vector2d& p : points) {
      p += kMapSigma * Eigen::Vector2d(normal(random), normal(random));
    }
    const double half_width = 2.5 + 1.5 * std::uniform_real_distribution<double>(0, 1)(random);
    town.plan.strips.push_back(
        {{streetmap::SegmentKind::kCarriageway, id++}, points, half_width, 0.3});
  }
  Polyline middle;
  for (int i = 0; i < kWalks && length_of(middle) < 0.9 * length; ++i) {
    middle = draw_walk(network, random, length);
  }
  town.drive = drive_on_right(middle);
  return town;
}

}  // namespace infuse::study
