#pragma once

#include "fusion/streetmap/global_start.hpp"

namespace infuse::streetmap {

/// Log-odds of poses against an estimate, by the streets that the drive followed until now. Where
/// one place alone explains the drive and the estimate is there, all others are refuted; elsewhere
/// the drive says nothing. Until the search is sure of the place the vehicle may be beside the
/// streets of the map, and no more is refuted than that is improbable.
class DriveOdds {
 public:
  DriveOdds(const std::optional<FoundPlace>& found, const GlobalStartOptions& options,
            const PlanarPose& estimate);

  double operator()(const PlanarPose& pose) const;

 private:
  double at(const PlanarPose& pose) const;

  PlanarPose found_;
  Eigen::Matrix2d information_ = Eigen::Matrix2d::Zero();  // of its position, 1/m²
  double same_place_ = 0;                                  // m; 0: the drive says nothing
  double refuted_ = 0;   // log-odds of all else against the place that was found
  double estimate_ = 0;  // the same of the estimate
  double beside_ = 0;    // probability of a drive beside the streets
};

}  // namespace infuse::streetmap
