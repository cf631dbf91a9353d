#pragma once

#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "fusion/mapping/submap.hpp"

namespace infuse::places {

/// Invented street in the map frame: ground, and walls, poles and boxes at random on both sides.
class InventedStreet {
 public:
  explicit InventedStreet(uint64_t seed, double length = 200) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (const double side : {-1.0, 1.0}) {
      for (double x = -30; x < length + 30;) {
        const double width = 4 + 10 * uniform(random), depth = 8 + 5 * uniform(random);
        const double y = side * (7 + 4 * uniform(random));
        add_wall({x, y}, {x + width, y}, 3 + 6 * uniform(random));
        add_wall({x, y}, {x, y + side * depth}, 3 + 6 * uniform(random));
        add_wall({x + width, y}, {x + width, y + side * depth}, 5);
        x += width + 2 + 8 * uniform(random);
        const double pole = x - 1 - uniform(random);
        for (double z = 0; z < 4; z += 0.1) add({pole, side * 5, z});
      }
    }
    for (double x = -60; x < length + 60; x += 0.4) {
      for (double y = -6.5; y < 6.5; y += 0.4) add({x, y, 0});
    }
  }

  /// Points that a lidar sees within `range` (m), in its frame, each with noise of 1 cm: those that
  /// no nearer point of their direction hides.
  mapping::Submap seen_from(const Eigen::Isometry3d& T_map_lidar, uint64_t seed,
                            double range = 50) const {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> noise(0, 0.01);
    mapping::Submap out;
    const Eigen::Isometry3d T_lidar_map = T_map_lidar.inverse();
    constexpr double kCell = 0.03;  // rad
    std::map<std::pair<int, int>, double> nearest;
    const auto cell_of = [](const Eigen::Vector3d& p) {
      return std::pair(static_cast<int>(std::floor(std::atan2(p.y(), p.x()) / kCell)),
                       static_cast<int>(std::floor(std::asin(p.z() / p.norm()) / kCell)));
    };
    std::vector<Eigen::Vector3d> near;
    for (const Eigen::Vector3d& point : points_) {
      const Eigen::Vector3d p = T_lidar_map * point;
      if (p.norm() > range || p.norm() < 2) continue;
      near.push_back(p);
      double& least = nearest.try_emplace(cell_of(p), range).first->second;
      least = std::min(least, p.norm());
    }
    for (const Eigen::Vector3d& p : near) {
      if (p.norm() > 1.1 * nearest[cell_of(p)]) continue;
      out.x.push_back(static_cast<float>(p.x() + noise(random)));
      out.y.push_back(static_cast<float>(p.y() + noise(random)));
      out.z.push_back(static_cast<float>(p.z() + noise(random)));
      out.reflectivity.push_back(0.3F);
    }
    return out;
  }

 private:
  void add(const Eigen::Vector3d& point) { points_.push_back(point); }
  void add_wall(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double height) {
    const double length = (to - from).norm();
    for (double s = 0; s < length; s += 0.35) {
      const Eigen::Vector2d p = from + s / length * (to - from);
      for (double z = 0; z < height; z += 0.35) add({p.x(), p.y(), z});
    }
  }

  std::vector<Eigen::Vector3d> points_;
};

/// Pose on the street: m along and across, rad.
inline Eigen::Isometry3d on_street(double along, double across, double yaw) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << along, across, 0;
  T.rotate(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  return T;
}

/// The lidar of the tests: above the vehicle's origin.
inline Eigen::Isometry3d lidar_above() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << 1, 0, 1.8;
  return T;
}

}  // namespace infuse::places
