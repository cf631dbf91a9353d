#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "fusion/streetmap/planar_pose.hpp"
#include "fusion/streetmap/segment_map.hpp"

namespace infuse::streetmap {

/// Settings of `PlaceCheck`.
struct PlaceCheckOptions {
  double spacing = 4;           ///< m between hypotheses along and across a street (decision 17)
  double max_along = 42;        ///< m, furthest pose along the heading
  double max_across = 26;       ///< m, furthest pose across the heading
  int like_places = 24;         ///< number of poses drawn on other carriageways, parallel streets
  double max_distance = 90;     ///< m of those
  double like_yaw = 0.08;       ///< rad, standard deviation of their headings about the estimate's
  double prior_odds = 0.1;      ///< of one other place before any evidence: one in ten
  double max_elsewhere = 0.02;  ///< of the other places, of one that is sure: one in 50
  double min_better = 2;        ///< log-odds, the prior included, above which a place is proposed

  /// True if a place with these log-odds of its views is to be proposed.
  bool is_better(double log_odds) const;

  /// Returns what is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

/// True if a pose is in the 99 % region of an estimate, with about its heading: it is the same
/// place. `covariance`: of the position, m².
bool is_in_region(const PlanarPose& pose, const PlanarPose& estimate,
                  const Eigen::Matrix2d& covariance);

/// Tests whether the true place is elsewhere: poses displaced along and across the street with the
/// heading of the estimate, along it with the reverse heading, and places on other carriageways.
/// Each is a rigid transform of the whole trajectory, so it drives with the estimate, and collects
/// the log-odds of its views against those of the estimate. A place is sure once all of them are
/// refuted together; on a straight street that looks alike everywhere it is not, until a crossing
/// or a turn.
class PlaceCheck {
 public:
  PlaceCheck(const PlaceCheckOptions& options, uint64_t seed);

  /// Begins a check of `pose`; places outside the map are left out.
  void start(const PlanarPose& pose, const SegmentMap& map);

  /// True from `start` until the place is sure.
  bool running() const { return running_; }

  /// Evaluates the other places on a view. `gain`: log-odds per unit of score of the view;
  /// `covariance` of the estimate on the map (`is_in_region`); `by_drive`: log-odds of a pose
  /// against the estimate by the streets that the drive followed until now.
  void update(const PlanarPose& estimate, const Eigen::Matrix2d& covariance, double gain,
              const std::function<double(const PlanarPose&)>& score,
              const std::function<double(const PlanarPose&)>& by_drive);

  /// Probability that the true place is one of the others; 1 before the first update.
  double elsewhere() const { return elsewhere_; }

  /// Why the place is not sure, static text; empty once it is.
  const char* reason() const;

  /// The likeliest other place if it is likelier than the estimate by `min_better`; once.
  std::optional<PlanarPose> propose();

 private:
  enum class Direction { kAlong, kAcross, kElsewhere };
  struct Place {
    PlanarPose T;  // of the estimate to this place, map frame
    Direction direction;
    double log_odds = 0;  // by the views
    double by_drive = 0;
    double total() const { return log_odds + by_drive; }
    bool same = false;  // within the region of the estimate
  };
  void add(const PlanarPose& from, const PlanarPose& to, const SegmentMap& map,
           Direction direction);
  double place_score(Place& place, const PlanarPose& estimate,
                     const std::function<double(const PlanarPose&)>& score);
  void judge();

  PlaceCheckOptions options_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  std::vector<Place> places_;
  PlanarPose estimate_;
  double elsewhere_ = 1;
  Direction likeliest_ = Direction::kAlong;
  bool running_ = false;
  bool first_view_ = true;  // since the start
};

}  // namespace infuse::streetmap
