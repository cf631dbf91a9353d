#pragma once

#include <random>

#include "fusion/registration/point_cloud.hpp"

namespace infuse::registration {

/// Points on the walls, the floor and a few boxes of a room, with noise along the ray; seeded.
inline PointCloud random_room(unsigned seed, size_t points, double noise,
                              const Eigen::Isometry3d& T_room_sensor) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::normal_distribution<double> normal(0, noise);
  std::mt19937 boxes(7);
  struct Box {
    Eigen::Vector3d centre, half;
  };
  std::vector<Box> all{{{0, 0, 2}, {15, 10, 4}}};
  for (int i = 0; i < 12; ++i) {
    all.push_back({{12 * unit(boxes), 8 * unit(boxes), -1}, {1, 1.2, 1}});
  }
  PointCloud cloud;
  cloud.resize(points);
  for (size_t i = 0; i < points; ++i) {
    const Box& box = all[i % 3 == 0 ? 1 + random() % (all.size() - 1) : 0];
    Eigen::Vector3d p(unit(random), unit(random), unit(random));
    const auto axis = static_cast<Eigen::Index>(random() % 3);
    p[axis] = p[axis] > 0 ? 1 : -1;
    p = box.centre + box.half.cwiseProduct(p);
    Eigen::Vector3d seen = T_room_sensor.inverse() * p;
    seen *= 1 + normal(random) / seen.norm();
    cloud.x[i] = static_cast<float>(seen.x());
    cloud.y[i] = static_cast<float>(seen.y());
    cloud.z[i] = static_cast<float>(seen.z());
  }
  return cloud;
}

}  // namespace infuse::registration
