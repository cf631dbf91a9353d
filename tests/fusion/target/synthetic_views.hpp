#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include "drivers/measurement/angles.hpp"
#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/sweep.hpp"
#include "fusion/geometry/camera_model.hpp"
#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/target/board.hpp"
#include "fusion/target/board_pose.hpp"
#include "fusion/target/target_view.hpp"

/// Boards of the size used in P (75 × 105 cm, 3.4.1.1) in view of a camera and a lidar, with known
/// truth.
namespace infuse::target::synthetic {

inline Board board() { return {.columns = 7, .rows = 5, .square_size = 0.13}; }

inline CameraIntrinsics intrinsics() {
  return {.width = 1280,
          .height = 960,
          .fx = 800,
          .fy = 805,
          .cx = 645,
          .cy = 470,
          .distortion = {-0.12, 0.03, 0.0004, -0.0003, 0}};
}

inline Eigen::Isometry3d true_T_camera_lidar() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  T.translation() = Eigen::Vector3d(0.2, -0.15, -0.3);
  geometry::Vector6 turn;
  turn << 0.02, -0.01, 0.015, 0, 0, 0;
  return geometry::exp(turn) * T;
}

inline Eigen::Isometry3d perturb(const Eigen::Isometry3d& T, double rad, double metres) {
  geometry::Vector6 xi;
  xi << rad, -rad, rad, metres, metres, -metres;
  return geometry::exp(xi / std::sqrt(3.0)) * T;
}

/// Random numbers that are the same with every standard library.
class RandomSource {
 public:
  explicit RandomSource(uint64_t seed) : random_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() >> 11) * 0x1p-53;
  }
  double normal() {
    return std::sqrt(-2 * std::log(uniform(1e-12, 1))) * std::cos(uniform(0, 2 * M_PI));
  }

 private:
  std::mt19937_64 random_;
};

/// A board 2 to 5 m from the camera, tilted by 20 to 50 degrees, completely in the image.
inline Eigen::Isometry3d random_board_pose(RandomSource& random, const Board& board) {
  const geometry::CameraModel camera(intrinsics());
  while (true) {
    const double depth = random.uniform(2, 5);
    const Eigen::Vector3d middle(depth * random.uniform(-0.6, 0.6),
                                 depth * random.uniform(-0.45, 0.45), depth);
    const double tilt = random.uniform(0.35, 0.87);
    const double towards = random.uniform(0, 2 * M_PI);
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() =
        Eigen::AngleAxisd(tilt, Eigen::Vector3d(std::cos(towards), std::sin(towards), 0)) *
        Eigen::AngleAxisd(random.uniform(-0.3, 0.3), Eigen::Vector3d::UnitZ()).toRotationMatrix();
    T.translation() = middle - T.linear() * board.middle();
    bool seen = true;
    for (size_t i = 0; i < board.corner_count(); ++i) {
      const auto pixel = camera.project(T * board.corner(i));
      seen = seen && pixel && camera.in_image(*pixel);
    }
    if (seen) return T;
  }
}

/// Distance at which a ray from `from` along `along` (unit vector) meets the board, m, including
/// the outermost squares.
inline std::optional<double> intersect(const Eigen::Isometry3d& T_board, const Board& board,
                                       const Eigen::Vector3d& from, const Eigen::Vector3d& along) {
  const Eigen::Vector3d normal = T_board.linear().col(2);
  const double range = normal.dot(T_board.translation() - from) / normal.dot(along);
  if (!(range > 0.3)) return std::nullopt;
  const Eigen::Vector3d at = T_board.inverse() * (from + range * along) - board.middle();
  const Eigen::Vector2d half = board.half_size();
  if (std::abs(at.x()) > half.x() || std::abs(at.y()) > half.y()) return std::nullopt;
  return range;
}

/// Calls `visit(along, ring, column)` for 64 beams from −24° to 16°, every 0.35° between ±50°.
template <class Visit>
void for_each_beam(const Visit& visit) {
  for (int column = 0; column < 286; ++column) {
    for (int ring = 0; ring < 64; ++ring) {
      const double azimuth = (50 - 0.35 * column) * kDegree;
      const double elevation = (-24 + 40.0 * ring / 63) * kDegree;
      visit(Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                            std::cos(elevation) * std::sin(azimuth), std::sin(elevation)),
            static_cast<uint16_t>(ring), static_cast<uint16_t>(column));
    }
  }
}

/// Sweep of the board and a wall 8 m away.
inline Sweep simulate_sweep(const Eigen::Isometry3d& T_lidar_board, const Board& board,
                            double noise, RandomSource& random) {
  Sweep sweep;
  sweep.rings = 64;
  for_each_beam([&](const Eigen::Vector3d& along, uint16_t ring, uint16_t column) {
    const double range =
        intersect(T_lidar_board, board, Eigen::Vector3d::Zero(), along).value_or(8 / along.x()) +
        noise * random.normal();
    const size_t i = sweep.size();
    sweep.resize(i + 1);
    sweep.x[i] = static_cast<float>(range * along.x());
    sweep.y[i] = static_cast<float>(range * along.y());
    sweep.z[i] = static_cast<float>(range * along.z());
    sweep.range[i] = static_cast<float>(range);
    sweep.reflectivity[i] = 0.5F;
    sweep.ring[i] = ring;
    sweep.column[i] = column;
  });
  return sweep;
}

inline Corners project_corners(const Eigen::Isometry3d& T_camera_board, const Board& board,
                               double noise, RandomSource& random) {
  const geometry::CameraModel camera(intrinsics());
  Corners corners;
  for (size_t i = 0; i < board.corner_count(); ++i) {
    corners.push_back(*camera.project(T_camera_board * board.corner(i)) +
                      noise * Eigen::Vector2d(random.normal(), random.normal()));
  }
  return corners;
}

/// Brightness where a ray meets a board with a white border half a square wide.
inline std::optional<double> brightness(const Eigen::Isometry3d& T_camera_board, const Board& board,
                                        const Eigen::Vector3d& along) {
  const Eigen::Vector3d normal = T_camera_board.linear().col(2);
  const double range = normal.dot(T_camera_board.translation()) / normal.dot(along);
  const Eigen::Vector3d at = T_camera_board.inverse() * (range * along);
  const double p = at.x() / board.square_size + 1;
  const double q = at.y() / board.square_size + 1;
  if (p < -0.5 || q < -0.5 || p > board.columns + 1.5 || q > board.rows + 1.5) return std::nullopt;
  const bool inside = p >= 0 && q >= 0 && p < board.columns + 1 && q < board.rows + 1;
  const bool dark = inside && (static_cast<int>(p) + static_cast<int>(q)) % 2 == 0;
  return dark ? 30 : 220;
}

/// Range biases of a lidar, m.
struct RangeErrors {
  double of_all = 0;
  double contrast = 0;  ///< of bright squares, beyond that of dark ones
  std::array<double, 64> of_beam{};

  static RangeErrors draw(double sigma, RandomSource& random) {
    RangeErrors errors{sigma * random.normal(), sigma * random.normal(), {}};
    for (double& bias : errors.of_beam) bias = sigma * random.normal();
    return errors;
  }
};

/// Views one board with both sensors, with the noise of both; the returns are exactly those on the
/// board.
inline TargetView make_view(const Eigen::Isometry3d& T_camera_board, const Board& board,
                            RandomSource& random, double range_noise = 0.02,
                            double corner_noise = 0.06, const RangeErrors& errors = {}) {
  const auto pose = estimate_board_pose(
      geometry::CameraModel(intrinsics()), board,
      project_corners(T_camera_board, board, corner_noise, random), corner_noise);
  TargetView view{.T_refcam_board = pose->T_camera_board,
                  .board_covariance = pose->covariance,
                  .returns = {},
                  .board = board};
  const Eigen::Isometry3d T_lidar_board = true_T_camera_lidar().inverse() * T_camera_board;
  for_each_beam([&](const Eigen::Vector3d& along, uint16_t ring, uint16_t) {
    const auto range = intersect(T_lidar_board, board, Eigen::Vector3d::Zero(), along);
    if (!range) return;
    const bool dark = brightness(T_lidar_board, board, along).value_or(0) < 128;
    const double bias =
        errors.of_all + errors.of_beam[ring] + (dark ? -0.5 : 0.5) * errors.contrast;
    view.returns.push_back(
        {(*range + bias + range_noise * random.normal()) * along, ring, dark ? 0.1 : 0.8});
  });
  return view;
}

inline std::vector<TargetView> make_views(int views, uint64_t seed,
                                          const Board& board = synthetic::board(),
                                          double range_noise = 0.02) {
  RandomSource random(seed);
  std::vector<TargetView> all;
  while (static_cast<int>(all.size()) < views) {
    TargetView view = make_view(random_board_pose(random, board), board, random, range_noise);
    if (view.returns.size() >= 30) all.push_back(std::move(view));
  }
  return all;
}

/// Image of boards in front of a grey wall, 3 × 3 rays per pixel.
inline CameraFrame render_image(const std::vector<Eigen::Isometry3d>& T_camera_boards,
                                const Board& board) {
  const geometry::CameraModel camera(intrinsics());
  CameraFrame frame;
  frame.width = intrinsics().width;
  frame.height = intrinsics().height;
  frame.pixels.assign(static_cast<size_t>(frame.width) * static_cast<size_t>(frame.height), 120);
  for (const Eigen::Isometry3d& T : T_camera_boards) {
    const Eigen::Vector2d middle = *camera.project(T * board.middle());
    const int reach = static_cast<int>(camera.intrinsics().fx * board.half_size().norm() * 1.3 /
                                       (T * board.middle()).z());
    for (int v = std::max(0, static_cast<int>(middle.y()) - reach);
         v < std::min(frame.height, static_cast<int>(middle.y()) + reach); ++v) {
      for (int u = std::max(0, static_cast<int>(middle.x()) - reach);
           u < std::min(frame.width, static_cast<int>(middle.x()) + reach); ++u) {
        auto& pixel = frame.pixels[static_cast<size_t>(v * frame.width + u)];
        double sum = 0;
        for (int k = 0; k < 9; ++k) {
          const auto along = camera.unproject({u + (k % 3 - 1) / 3.0, v + (k / 3 - 1) / 3.0});
          sum += along ? brightness(T, board, *along).value_or(pixel) : pixel;
        }
        pixel = static_cast<uint8_t>(sum / 9 + 0.5);
      }
    }
  }
  return frame;
}

inline double degrees_between(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return geometry::log(a * b.inverse()).head<3>().norm() / kDegree;
}

/// Distance of the two lidar origins in the camera frame, m.
inline double metres_between(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (a.translation() - b.translation()).norm();
}

}  // namespace infuse::target::synthetic
