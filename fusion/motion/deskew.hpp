#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/sweep.hpp"
#include "fusion/geometry/trajectory.hpp"

namespace infuse::motion {

/// How exactly a sweep is made straight.
struct DeskewOptions {
  double tolerance = 1e-4;  ///< m: how far a return may be from where its own pose puts it
  double max_range = 250;   ///< m: up to which range `tolerance` holds; beyond, in proportion
  size_t max_cells = 2048;  ///< pieces of a sweep; a motion that needs more is not believed

  /// What is wrong with the options, or nothing.
  std::optional<std::string> invalid() const;
};

/// A sweep's returns as if all of them had been taken at one time; the other quantities stay in the
/// sweep, index for index.
struct DeskewedSweep {
  Stamp reference;                 ///< the time; x, y and z are in the lidar frame of that time
  FieldVector<float> x, y, z;      ///< m
  geometry::MotionBetween motion;  ///< of the vehicle, from the first return to the last
  const char* reason = "";  ///< static text: why x, y and z are as they were measured; empty when
                            ///< they are corrected

  /// The returns are corrected for motion.
  bool usable() const { return *reason == '\0'; }
};

/// Corrects sweeps for the motion of the vehicle while they were taken.
///
/// A trajectory moves at constant twist between two poses; each such piece is cut into cells, at
/// whose ends the pose is exact and within which its matrix is blended linearly. A point at range r
/// then errs by at most h² |ω| (|ω| r + |v|) / 8 in a cell of h seconds (second derivative of a
/// motion at constant twist), from which the number of cells follows.
class Deskewer {
 public:
  /// `options.invalid()` must be empty.
  explicit Deskewer(const Eigen::Isometry3d& T_vehicle_lidar, const DeskewOptions& options = {});

  /// Writes the sweep as of `reference` (its start, its end, a camera's exposure). Where the
  /// trajectory does not cover all of the returns and the reference, or the sweep has no times, the
  /// returns are copied as they are and `straight.reason` says why. Allocates nothing once
  /// `straight` has been as large. The same bytes on every processor.
  void deskew(const Sweep& sweep, const geometry::Trajectory& trajectory, Stamp reference,
              DeskewedSweep& deskewed);

 private:
  using Matrix34f = std::array<float, 12>;  // by row

  /// A piece of time within which the pose is start + u · change, u = (offset − begin) · rate.
  struct Cell {
    int32_t begin = 0, end = 0;  // ns after the sweep's stamp
    float rate = 0;              // 1/ns
    Matrix34f start{}, change{};
  };

  const char* build_cells(const Sweep& sweep, const geometry::Trajectory& trajectory,
                          const Eigen::Isometry3d& T_reference_odom, int32_t first, int32_t last);
  const char* add_cells(const geometry::StampedPose& from, const geometry::StampedPose& to,
                        const Eigen::Isometry3d& T_reference_odom, Stamp origin, int32_t begin,
                        int32_t end);
  void apply_cells(const Sweep& sweep, DeskewedSweep& deskewed) const;
  size_t find_cell(int32_t offset, size_t hint) const;
  static void transform(const Cell& cell, const Sweep& sweep, size_t from, size_t to,
                        DeskewedSweep& deskewed);

  Eigen::Isometry3d T_vehicle_lidar_;
  DeskewOptions options_;
  std::vector<Cell> cells_;
};

}  // namespace infuse::motion
