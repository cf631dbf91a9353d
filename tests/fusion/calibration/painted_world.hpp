#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "drivers/measurement/angles.hpp"
#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/sweep.hpp"
#include "fusion/calibration/scene.hpp"
#include "fusion/calibration/visible_points.hpp"
#include "fusion/geometry/camera_model.hpp"
#include "fusion/geometry/rigid_motion.hpp"

/// A small world with known truth: boxes with painted faces on a painted floor between painted
/// walls, seen by a lidar at the origin (rays cast exactly) and by a camera (rays cast through
/// every pixel).
namespace infuse::calibration::painted {

/// Rectangle centre ± a ± b with its own pattern.
struct Face {
  Eigen::Vector3d centre, a, b;
  double base = 0.5;               ///< albedo
  double pattern_amplitude = 0.0;  ///< amplitude of its pattern
  double pattern_period = 1.0;     ///< m, of the pattern
};

struct World {
  std::vector<Face> faces;
};

struct Hit {
  double distance;
  double albedo;  ///< 0 … 1
};

inline std::optional<Hit> cast_ray(const World& world, const Eigen::Vector3d& from,
                                   const Eigen::Vector3d& along) {
  std::optional<Hit> nearest;
  for (const Face& face : world.faces) {
    const Eigen::Vector3d normal = face.a.cross(face.b);
    const double slope = normal.dot(along);
    if (std::abs(slope) < 1e-12) continue;
    const double distance = normal.dot(face.centre - from) / slope;
    if (distance < 0.1 || (nearest && distance >= nearest->distance)) continue;
    const Eigen::Vector3d on = from + distance * along - face.centre;
    const double s = on.dot(face.a) / face.a.squaredNorm();
    const double t = on.dot(face.b) / face.b.squaredNorm();
    if (std::abs(s) > 1 || std::abs(t) > 1) continue;
    const double p = s * face.a.norm() / face.pattern_period;
    const double q = t * face.b.norm() / face.pattern_period;
    const double pattern = std::sin(2 * M_PI * p) * std::sin(2 * M_PI * q + 1.0) > 0 ? 1 : -1;
    nearest = Hit{distance, std::clamp(face.base + face.pattern_amplitude * pattern, 0.0, 1.0)};
  }
  return nearest;
}

/// Walls at `scale` times 10 to 14 m and a few boxes before them, drawn from the seed.
inline World make_world(uint64_t seed, double scale = 1) {
  std::mt19937_64 random(seed);
  const auto draw = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  World world;
  const auto add = [&](const Eigen::Vector3d& centre, const Eigen::Vector3d& a,
                       const Eigen::Vector3d& b) {
    world.faces.push_back({scale * centre, scale * a, scale * b, draw(0.15, 0.85), draw(0.05, 0.15),
                           scale * draw(0.7, 2.0)});
  };
  add({7, 0, -1.7}, {7, 0, 0}, {0, 8, 0});
  add({draw(11, 14), 0, 2}, {0, 9, 0}, {0, 0, 4});
  add({7, draw(6, 8), 2}, {7, 0, 0}, {0, 0, 4});
  add({7, draw(-8, -6), 2}, {7, 0, 0}, {0, 0, 4});
  for (int i = 0; i < 9; ++i) {
    const Eigen::Vector3d at{draw(4, 10), draw(-5, 5), draw(-1.4, 1.6)};
    const double turn = draw(-0.6, 0.6);
    const Eigen::Vector3d across(-std::sin(turn), std::cos(turn), 0);
    const Eigen::Vector3d deep(std::cos(turn), std::sin(turn), 0);
    const double half = draw(0.25, 0.8);
    const double tall = draw(0.25, 0.9);
    const double far = draw(0.2, 0.6);
    add(at, half * across, {0, 0, tall});
    add(at + far * deep + half * across, far * deep, {0, 0, tall});
    add(at + far * deep - half * across, far * deep, {0, 0, tall});
  }
  return world;
}

/// Camera along x of the lidar, 0.3 m in front of and 0.2 m beside it.
inline Eigen::Isometry3d true_T_camera_lidar() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  T.translation() = Eigen::Vector3d(0.2, -0.1, -0.3);
  geometry::Vector6 turn;
  turn << 0.02, -0.01, 0.015, 0, 0, 0;
  return geometry::exp(turn) * T;
}

inline CameraIntrinsics small_camera() {
  return {.width = 480, .height = 320, .fx = 330, .fy = 330, .cx = 241, .cy = 158};
}

/// Lidar: rings from `low` to `high` degrees, columns over ± `half_width` degrees.
/// Reflectivity is a nonlinear function of the albedo, with noise; so is range.
struct Scanner {
  uint16_t rings = 48;
  double low = -20, high = 14;
  uint16_t columns = 501;
  double half_width = 50;
  double range_noise = 0;  ///< m, half width
};

inline Sweep scan(const World& world, uint64_t seed, const Scanner& scanner = {}) {
  std::mt19937_64 random(seed);
  const auto noise = [&] { return static_cast<double>(random() >> 11) * 0x1p-53 - 0.5; };
  Sweep sweep;
  sweep.rings = scanner.rings;
  sweep.columns = scanner.columns;
  sweep.has_times = false;
  const double apart = 2 * scanner.half_width / (scanner.columns - 1);
  for (uint16_t column = 0; column < scanner.columns; ++column) {
    for (uint16_t ring = 0; ring < scanner.rings; ++ring) {
      const double azimuth = (scanner.half_width - apart * column) * kDegree;
      const double rise =
          scanner.rings > 1 ? (scanner.high - scanner.low) * ring / (scanner.rings - 1) : 0;
      const double elevation = (scanner.low + rise) * kDegree;
      const Eigen::Vector3d along(std::cos(elevation) * std::cos(azimuth),
                                  std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      const auto hit = cast_ray(world, Eigen::Vector3d::Zero(), along);
      if (!hit) continue;
      const size_t i = sweep.size();
      sweep.resize(i + 1);
      const double reflectivity = std::pow(hit->albedo, 1.7) + 0.02 * noise();
      const double range =
          hit->distance + (scanner.range_noise > 0 ? 2 * scanner.range_noise * noise() : 0);
      sweep.x[i] = static_cast<float>(range * along.x());
      sweep.y[i] = static_cast<float>(range * along.y());
      sweep.z[i] = static_cast<float>(range * along.z());
      sweep.range[i] = static_cast<float>(range);
      sweep.reflectivity[i] = static_cast<float>(reflectivity);
      sweep.ring[i] = ring;
      sweep.column[i] = column;
      sweep.time_offset_ns[i] = 0;
      sweep.return_kind[i] = ReturnKind::kStrongest;
    }
  }
  return sweep;
}

/// Renders the image; the light falls off towards the left, and all beyond the walls is white.
inline CameraFrame render_image(const World& world, const CameraIntrinsics& intrinsics,
                                const Eigen::Isometry3d& T_camera_lidar) {
  const geometry::CameraModel model(intrinsics);
  const Eigen::Isometry3d T_lidar_camera = T_camera_lidar.inverse();
  CameraFrame frame;
  frame.width = intrinsics.width;
  frame.height = intrinsics.height;
  for (int v = 0; v < frame.height; ++v) {
    for (int u = 0; u < frame.width; ++u) {
      const auto along = model.unproject(Eigen::Vector2d(u, v));
      const auto hit =
          along ? cast_ray(world, T_lidar_camera.translation(), T_lidar_camera.linear() * *along)
                : std::nullopt;
      const double light = 0.7 + 0.3 * u / frame.width;
      frame.pixels.push_back(static_cast<uint8_t>(255 * (hit ? light * hit->albedo : 1.0)));
    }
  }
  return frame;
}

/// Scenes of different places and their camera.
struct Drive {
  std::vector<Scene> scenes;
  std::vector<RigCamera> cameras;
  Eigen::Isometry3d T_camera_lidar;
};

inline Drive make_drive(int scenes, double scale = 1, const Scanner& scanner = {},
                        const Eigen::Isometry3d& T_camera_lidar = true_T_camera_lidar()) {
  Drive drive{.cameras = {RigCamera{geometry::CameraModel(small_camera())}},
              .T_camera_lidar = T_camera_lidar};
  for (int s = 0; s < scenes; ++s) {
    const World world = make_world(static_cast<uint64_t>(s) + 1, scale);
    SceneOptions options{
        .rings = features::ring_directions(drive.cameras.front().model, drive.T_camera_lidar)};
    options.max_range = 1e4;
    options.min_range = std::min(options.min_range, scale);
    auto scene = make_scene(scan(world, 100 + static_cast<uint64_t>(s), scanner),
                            render_image(world, small_camera(), drive.T_camera_lidar), options);
    scene->name = "place " + std::to_string(s);
    drive.scenes.push_back(std::move(*scene));
  }
  return drive;
}

inline double degrees_between(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return geometry::log(a * b.inverse()).head<3>().norm() / kDegree;
}

inline double metres_between(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return geometry::log(a * b.inverse()).tail<3>().norm();
}

/// Twelve scenes, rendered once.
inline const Drive& twelve_scene_drive() {
  static const Drive drive = make_drive(12);
  return drive;
}

}  // namespace infuse::calibration::painted
