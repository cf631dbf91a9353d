#include "fusion/target/board_returns.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace infuse::target {
namespace {

using Returns = std::vector<BoardReturn>;

/// Minimum standard deviation of the returns as a fraction of the board's half size: that of
/// returns on the middle half.
constexpr double kMinRelativeWidth = 0.29;  // 1/√12, the standard deviation of a uniform density

/// Plane of the points x with normal · x = distance.
struct Plane {
  Eigen::Vector3d normal;
  double distance;

  double distance_to(const Eigen::Vector3d& point) const {
    return std::abs(normal.dot(point) - distance);
  }
};

/// True if a point in the board frame lies within the outline of the board, grown by `grow`, and
/// within the thickness of its plane.
bool in_box(const Eigen::Vector3d& on_board, const Board& board, double grow,
            double half_thickness) {
  const Eigen::Vector3d at = on_board - board.middle();
  const Eigen::Vector2d half = board.half_size() + Eigen::Vector2d::Constant(grow);
  return std::abs(at.x()) <= half.x() && std::abs(at.y()) <= half.y() &&
         std::abs(at.z()) <= half_thickness;
}

std::optional<Plane> plane_through(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                   const Eigen::Vector3d& c) {
  const Eigen::Vector3d cross = (b - a).cross(c - a);
  const double area = cross.norm();
  if (!(area > 1e-4)) return std::nullopt;
  const Eigen::Vector3d normal = cross / area;
  return Plane{normal, normal.dot(a)};
}

Returns select_inliers(const Returns& returns, const Plane& plane, double thickness) {
  Returns inliers;
  for (const BoardReturn& seen : returns) {
    if (plane.distance_to(seen.point) <= thickness) inliers.push_back(seen);
  }
  return inliers;
}

std::optional<Plane> ransac_plane(const Returns& returns, const Eigen::Vector3d& facing,
                                  const BoardReturnsOptions& options) {
  std::mt19937_64 random(options.seed);
  const auto draw = [&] { return returns[random() % returns.size()].point; };
  std::optional<Plane> best;
  size_t max_count = 0;
  for (int k = 0; k < options.ransac_iterations; ++k) {
    const std::array drawn{draw(), draw(), draw()};  // braces: in this order, whatever the compiler
    const auto plane = plane_through(drawn[0], drawn[1], drawn[2]);
    if (!plane || std::abs(plane->normal.dot(facing)) < std::cos(options.max_tilt)) continue;
    const auto count =
        static_cast<size_t>(std::count_if(returns.begin(), returns.end(), [&](const auto& seen) {
          return plane->distance_to(seen.point) <= options.thickness;
        }));
    if (count > max_count) {
      max_count = count;
      best = plane;
    }
  }
  return best;
}

}  // namespace

std::optional<std::string> BoardReturnsOptions::invalid() const {
  if (!(margin > 0)) return "margin must be positive";
  if (!(max_tilt > 0) || !(max_tilt < 1.5)) return "max_tilt must be between 0 and 1.5";
  if (!(thickness > 0)) return "thickness must be positive";
  if (min_returns < 3) return "min_returns must be at least 3";
  if (ransac_iterations < 1) return "ransac_iterations must be at least 1";
  return std::nullopt;
}

Returns crop_to_board(const Sweep& sweep, const Eigen::Isometry3d& T_lidar_board,
                      const Board& board, double margin) {
  const Eigen::Isometry3d T_board_lidar = T_lidar_board.inverse();
  Returns near;
  for (size_t i = 0; i < sweep.size(); ++i) {
    const Eigen::Vector3d point(sweep.x[i], sweep.y[i], sweep.z[i]);
    if (in_box(T_board_lidar * point, board, margin, margin)) {
      near.push_back({point, sweep.ring[i], double{sweep.reflectivity[i]}});
    }
  }
  return near;
}

Result<Returns> find_board_returns(std::span<const BoardReturn> all,
                                   const Eigen::Isometry3d& T_lidar_board, const Board& board,
                                   double grow, const BoardReturnsOptions& options) {
  const Eigen::Isometry3d T_board_lidar = T_lidar_board.inverse();
  Returns near;
  for (const BoardReturn& seen : all) {
    if (in_box(T_board_lidar * seen.point, board, grow, options.margin)) near.push_back(seen);
  }
  const auto min_returns = static_cast<size_t>(options.min_returns);
  if (near.size() < min_returns) {
    return fail("only " + std::to_string(near.size()) +
                " returns at the expected place of the board");
  }
  const Eigen::Vector3d facing = T_lidar_board.linear().col(2);
  const auto plane = ransac_plane(near, facing, options);
  if (!plane) return fail("no plane among the returns has the orientation of the board");
  Returns inliers = select_inliers(near, *plane, options.thickness);
  if (inliers.size() >= min_returns) {
    const ReturnsPlane best = fit_returns_plane(inliers);
    inliers = select_inliers(near, {best.normal, best.normal.dot(best.mean)}, options.thickness);
  }
  if (inliers.size() < min_returns) {
    return fail("only " + std::to_string(inliers.size()) + " returns lie on the board");
  }
  // A strip results where another surface crosses the searched plane.
  if (fit_returns_plane(inliers).width < kMinRelativeWidth * board.half_size().minCoeff()) {
    return fail("the returns cover only a strip of the board");
  }
  return inliers;
}

}  // namespace infuse::target
