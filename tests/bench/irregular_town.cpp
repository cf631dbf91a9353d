#include "tests/bench/irregular_town.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::streetmap::bench {
namespace {

constexpr double kBlock = 100, kShift = 25;  // m, between crossings, of a crossing at most
constexpr double kPresent = 0.85;            // of the streets
constexpr double kAhead = 6;                 // m, to which the vehicle steers

}  // namespace

IrregularTown::IrregularTown(double area, uint64_t seed)
    : edge_(std::max(static_cast<int>(std::sqrt(area) / kBlock), 3)) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> shift(-kShift, kShift), share(0, 1);
  for (int row = 0; row < edge_; ++row) {
    for (int column = 0; column < edge_; ++column) {
      const double x = kBlock * column + shift(random), y = kBlock * row + shift(random);
      const bool east = share(random) < kPresent, north = share(random) < kPresent;
      crossings_.push_back({{x, y}, east && column + 1 < edge_, north && row + 1 < edge_});
    }
  }
}

StreetPlan IrregularTown::plan() const {
  constexpr double kHalfWidth = 3.5, kKerb = 0.4;  // m
  StreetPlan plan;
  int64_t id = 1;
  const auto add = [&](const Crossing& from, const Crossing& to) {
    plan.strips.push_back({{SegmentKind::kCarriageway, id++}, {from.at, to.at}, kHalfWidth, kKerb});
  };
  for (int i = 0; i < edge_ * edge_; ++i) {
    const Crossing& crossing = crossings_[static_cast<size_t>(i)];
    if (crossing.east) add(crossing, crossings_[static_cast<size_t>(i + 1)]);
    if (crossing.north) add(crossing, crossings_[static_cast<size_t>(i + edge_)]);
  }
  return plan;
}

std::vector<int> IrregularTown::next_to(int crossing) const {
  std::vector<int> all;
  const auto at = [&](int i) { return crossings_[static_cast<size_t>(i)]; };
  if (at(crossing).east) all.push_back(crossing + 1);
  if (at(crossing).north) all.push_back(crossing + edge_);
  if (crossing % edge_ > 0 && at(crossing - 1).east) all.push_back(crossing - 1);
  if (crossing >= edge_ && at(crossing - edge_).north) all.push_back(crossing - edge_);
  return all;
}

std::vector<PlanarPose> IrregularTown::drive(double length, double step, uint64_t seed) const {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> share(0, 1);
  const auto at = [&](int i) { return crossings_[static_cast<size_t>(i)].at; };
  int from = 0, to = 0;
  while (from == to) {
    from = static_cast<int>(share(random) * edge_ * edge_);
    const auto all = next_to(from);
    if (all.size() > 1)
      to = all[static_cast<size_t>(share(random) * static_cast<double>(all.size()))];
  }
  const Eigen::Vector2d first = at(to) - at(from);
  std::vector<PlanarPose> poses{{at(from).x(), at(from).y(), std::atan2(first.y(), first.x())}};
  std::vector<Eigen::Vector2d> line{at(from), at(to)};  // the street and what follows
  for (double driven = 0; driven < length; driven += step) {
    PlanarPose pose = poses.back();
    const Eigen::Vector2d p(pose.x, pose.y);
    const Eigen::Vector2d d = (line[1] - line[0]).normalized();
    const double along = d.dot(p - line[0]), left = (line[1] - line[0]).norm() - along;
    Eigen::Vector2d goal = line[0] + (along + kAhead) * d;
    if (left < kAhead) {
      if (line.size() == 2) {
        auto all = next_to(to);
        if (all.size() > 1) std::erase(all, from);
        std::sort(all.begin(), all.end(), [&](int a, int b) {
          return d.dot((at(a) - at(to)).normalized()) > d.dot((at(b) - at(to)).normalized());
        });
        const bool turns = all.size() > 1 && share(random) < 0.5;
        const size_t chosen =
            turns ? 1 + static_cast<size_t>(share(random) * static_cast<double>(all.size() - 1))
                  : 0;
        from = to;
        to = all[chosen];
        line.push_back(at(to));
      }
      goal = line[1] + (kAhead - std::max(left, 0.0)) * (line[2] - line[1]).normalized();
      if (left < 0.5) line.erase(line.begin());
    }
    const double error = wrap_angle(std::atan2(goal.y() - pose.y, goal.x() - pose.x) - pose.yaw);
    poses.push_back(pose.compose({step, 0, std::clamp(error, -0.25 * step, 0.25 * step)}));
  }
  return poses;
}

}  // namespace infuse::streetmap::bench
