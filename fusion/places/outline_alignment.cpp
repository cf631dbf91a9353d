#include "fusion/places/outline_alignment.hpp"

#include <cmath>
#include <cstdint>
#include <vector>

#include "fusion/places/ground_height.hpp"

namespace infuse::places {
namespace {

/// What stands on the ground within range of a vehicle, from above.
std::vector<Eigen::Vector2d> outline(const geometry::PointsView& points,
                                     const Eigen::Isometry3d& T_vehicle_lidar,
                                     const OutlineOptions& options) {
  std::vector<Eigen::Vector3d> about;
  for (size_t i = 0; i < points.x.size(); ++i) {
    const Eigen::Vector3d p =
        T_vehicle_lidar * Eigen::Vector3d(points.x[i], points.y[i], points.z[i]);
    if (p.head<2>().norm() < options.range) about.push_back(p);  // NaN is not
  }
  const double ground = ground_height(about);
  std::vector<Eigen::Vector2d> out;
  for (const Eigen::Vector3d& p : about) {
    const double height = p.z() - ground;
    if (height > options.min_height && height < options.max_height) out.push_back(p.head<2>());
  }
  return out;
}

/// Cells about the origin, in rows.
class Grid {
 public:
  explicit Grid(const OutlineOptions& options)
      : cell_(options.cell),
        half_(static_cast<int>(std::ceil((options.range + options.max_shift) / cell_)) + 2),
        cells_(static_cast<size_t>(width()) * static_cast<size_t>(width())) {}

  int width() const { return 2 * half_ + 1; }
  /// Index of the cell of a point; nothing is outside that lies in range of a shifted outline.
  size_t index(const Eigen::Vector2d& p) const {
    const auto column = [&](double x) {
      return static_cast<size_t>(
          std::clamp(static_cast<int>(std::floor(x / cell_)) + half_, 1, width() - 2));
    };
    return column(p.y()) * static_cast<size_t>(width()) + column(p.x());
  }
  uint8_t& operator[](size_t i) { return cells_[i]; }

 private:
  double cell_;
  int half_;
  std::vector<uint8_t> cells_;
};

}  // namespace

Eigen::Isometry3d align_outlines(const geometry::PointsView& target,
                                 const Eigen::Isometry3d& T_target_lidar,
                                 const geometry::PointsView& source,
                                 const Eigen::Isometry3d& T_source_lidar, double yaw_guess,
                                 const OutlineOptions& options) {
  Grid grid(options);
  const auto width = static_cast<std::ptrdiff_t>(grid.width());
  for (const Eigen::Vector2d& p : outline(target, T_target_lidar, options)) {
    // A cell counts two, its neighbours one: the pose may lie between two cells.
    const auto at = static_cast<std::ptrdiff_t>(grid.index(p));
    for (const std::ptrdiff_t beside : {at - 1, at + 1, at - width, at + width}) {
      uint8_t& cell = grid[static_cast<size_t>(beside)];
      cell = std::max<uint8_t>(cell, 1);
    }
    grid[static_cast<size_t>(at)] = 2;
  }
  const std::vector<Eigen::Vector2d> points = outline(source, T_source_lidar, options);
  const int shifts = static_cast<int>(options.max_shift / options.cell);
  const int turns = static_cast<int>(options.max_turn / options.turn_step);
  Eigen::Isometry3d best = Eigen::Isometry3d::Identity();
  best.rotate(Eigen::AngleAxisd(yaw_guess, Eigen::Vector3d::UnitZ()));
  int64_t best_score = 0;
  for (int turn = -turns; turn <= turns; ++turn) {
    const double yaw = yaw_guess + turn * options.turn_step;
    const Eigen::Rotation2Dd rotation(yaw);
    Grid occupied(options);  // one point per cell, so that walls near the lidar count no more
    std::vector<std::ptrdiff_t> cells;
    for (const Eigen::Vector2d& p : points) {
      const size_t at = occupied.index(rotation * p);
      if (occupied[at]++ == 0) cells.push_back(static_cast<std::ptrdiff_t>(at));
      occupied[at] = 1;
    }
    for (int dy = -shifts; dy <= shifts; ++dy) {
      for (int dx = -shifts; dx <= shifts; ++dx) {
        const std::ptrdiff_t shift = dy * width + dx;
        int64_t score = 0;
        for (const std::ptrdiff_t at : cells) score += grid[static_cast<size_t>(at + shift)];
        if (score <= best_score) continue;
        best_score = score;
        best = Eigen::Isometry3d::Identity();
        best.translation() << dx * options.cell, dy * options.cell, 0;
        best.rotate(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
      }
    }
  }
  return best;
}

}  // namespace infuse::places
