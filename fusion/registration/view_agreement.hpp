#pragma once

#include <Eigen/Geometry>

#include "fusion/registration/gicp.hpp"
#include "fusion/registration/range_image.hpp"

namespace infuse::registration {

/// m, by which a beam must go on behind a place to refute what is there.
inline constexpr double kClearance = 1;

/// Least share of the points that two scans can judge of each other and support, and of all points,
/// of a pose found without or with a guess.
inline constexpr double kMinPlaceAgreement = 0.85, kMinPlaceOverlap = 0.25;

/// What one scan sees of the points of another at a pose, in numbers of points.
struct ViewAgreement {
  size_t supported = 0;  ///< with a point of the scan beside them
  size_t refuted = 0;    ///< the scan's beams passed through their place
  size_t unseen = 0;     ///< hidden from the scan, or outside of its view

  /// Share of supported points among those that the scan can judge; 0 if there is none.
  double share() const;

  /// Share of supported points among all; 0 if there is none.
  double overlap() const;

  /// Share times number of supported points: grows with the overlap, falls with what is refuted.
  double score() const { return share() * static_cast<double>(supported); }

  ViewAgreement operator+(const ViewAgreement& other) const;
};

/// Range image of a scan and its points. Tells whether something that another scan measured can be
/// where a pose puts it: a beam that passed through a place has found it empty. Planes that fit
/// anywhere along themselves, such as the ground and the houses of a street, can not tell a wrong
/// pose by their points alone.
class ViewOfScan {
 public:
  /// The cloud must outlive this object; its origin is the sensor.
  explicit ViewOfScan(const PreparedCloud& scan) : scan_(scan), ranges_(scan.cloud.points()) {}

  /// Judges the points of another scan at its pose in this scan's frame. Points whose normal is
  /// along the commonest normal of their scan (the ground) are left out.
  ViewAgreement judge(const PointCloud& other, const Eigen::Isometry3d& T_this_other) const;

 private:
  const PreparedCloud& scan_;
  RangeImage ranges_;
};

/// Both ways: the source's points in the target's view and the target's in the source's.
ViewAgreement agreement(const ViewOfScan& target, const PointCloud& target_cloud,
                        const ViewOfScan& source, const PointCloud& source_cloud,
                        const Eigen::Isometry3d& T_target_source);

}  // namespace infuse::registration
