#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/sweep.hpp"
#include "fusion/geometry/trajectory.hpp"

namespace infuse::motion {

/// Settings of the motion compensation.
struct DeskewOptions {
  double tolerance = 1e-4;  ///< m of a return's place: a twentieth of the steps of a range (HDL-32E
                            ///< manual)
  double max_range = 250;   ///< m, up to which `tolerance` holds: 245 m on the data sheet of a
                            ///< VLS-128; beyond, the error grows in proportion
  size_t max_cells = 2048;  ///< of a sweep, bounds memory: a motion that needs more is rejected

  /// Returns what is wrong with the options, or nothing.
  std::optional<std::string> invalid() const;
};

/// Coordinates of a sweep's returns as if all had been measured at one time. The other fields stay
/// in the sweep, with the same indices.
struct DeskewedSweep {
  Stamp reference;                 ///< that time; x, y and z are in the lidar frame at this time
  FieldVector<float> x, y, z;      ///< m
  geometry::MotionBetween motion;  ///< vehicle motion from the first return to the last
  const char* reason = "";  ///< static text: why x, y and z are uncorrected; empty if they are
                            ///< corrected

  /// True if the returns are corrected for motion.
  bool usable() const { return *reason == '\0'; }
};

/// Deskews sweeps: corrects them for the motion of the vehicle during the sweep.
///
/// A trajectory has constant twist between two poses. Each such segment is cut into cells; the pose
/// is exact at the ends of a cell and its matrix is interpolated linearly within. The error of a
/// point at range r is at most h² |ω| (|ω| r + |v|) / 8 in a cell of h seconds (second derivative
/// of a constant-twist motion), which determines the number of cells.
class Deskewer {
 public:
  /// `options.invalid()` must be empty.
  explicit Deskewer(const Eigen::Isometry3d& T_vehicle_lidar, const DeskewOptions& options = {});

  /// Deskews a sweep to the time `reference` (its start, its end, the exposure of a camera). If the
  /// trajectory does not cover all returns and the reference, or the sweep has no times, copies the
  /// returns unchanged and sets `deskewed.reason`. Does not allocate once `deskewed` has reached
  /// its size. Same bytes on every processor.
  void deskew(const Sweep& sweep, const geometry::Trajectory& trajectory, Stamp reference,
              DeskewedSweep& deskewed);

 private:
  using Matrix34f = std::array<float, 12>;  // row-major

  /// Time interval in which the pose is start + u · change, with u = (offset − begin) · rate.
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
