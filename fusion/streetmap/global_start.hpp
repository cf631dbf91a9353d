#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fusion/streetmap/planar_pose.hpp"
#include "fusion/streetmap/street_grid.hpp"

namespace infuse::streetmap {

/// Settings of `GlobalStart`.
struct GlobalStartOptions {
  bool enabled = true;            ///< search all streets while the place is not sure
  double spacing = 4;             ///< m between hypotheses along and across a street (decision 17)
  int max_hypotheses = 60000;     ///< the spacing grows until no more are needed (decision 17)
  int max_compared = 5000;        ///< hypotheses that are compared at each motion: bounds time
  double step = 2;                ///< m driven between two comparisons with the streets; longer
                                  ///< while the hypotheses are many (decision 17)
  double independent_length = 8;  ///< m driven until the next evidence is independent (decision 17)
  double street_sigma = 1.5;      ///< m, of a street's edge against the drive (decision 17)
  double max_misfit = 4;          ///< log-weight that evidence takes at most: 0.5 % of a Gaussian
  double scale_sigma = 0.01;      ///< of true over measured distance; derived from the particles'
  double yaw_rate_sigma = 0.001;  ///< rad/s, lasting error; derived from the particles'
  double yaw_noise = 0.002;       ///< rad per √m driven (decision 17)
  double believed_radius = 100;   ///< m, of streets that are likelier where a pose is believed
  double believed_log_odds = 3;   ///< of one of them against one beyond: one in twenty is wrong
  double max_log_odds = 16;       ///< a hypothesis worse by more is dropped: right one in 8 900 000
  double same_place = 15;         ///< m within which hypotheses are one place (decision 17)
  double min_alone = 150;         ///< m driven, all else improbable, until it is sure (decision 16)
  double turn_worth = 40;  ///< m of it that a radian turned meanwhile counts for (decision 16)
  int max_witnessed = 48;  ///< hypotheses that sensor data are compared with; 0: never
  double max_mean_misfit = 0.02;  ///< of independent evidence of a place that is sure (decision 16)
  double max_elsewhere = 0.01;    ///< of all else, of a place that is sure: one in a hundred
  double max_sigma = 6;           ///< m, of a place that is sure (decision 17)

  /// Returns what is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

/// True if two poses are one place: within `distance` (m) and with headings within 0.5 rad.
bool is_same_place(const PlanarPose& a, const PlanarPose& b, double distance);

/// Where the vehicle probably is when a search begins.
struct BelievedPlace {
  PlanarPose pose;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< x, y (m, map frame), yaw (rad)
  bool confirmed = false;  ///< the drive went on from a place that was sure
};

/// One of the places where the vehicle may be.
struct PossiblePlace {
  PlanarPose pose;                                       ///< map frame
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< x, y (m, map frame), yaw (rad)
  double probability = 0;
};

/// Places that look alike, the likeliest first; what their probabilities lack is elsewhere.
class PossiblePlaces {
 public:
  static constexpr size_t kMaxCount = 4;           ///< bounds the memory
  static constexpr double kMinProbability = 0.05;  ///< of a place that is reported: one in twenty

  /// False, and nothing changes, if there are as many already.
  bool add(const PossiblePlace& place);
  std::span<const PossiblePlace> all() const { return {places_.data(), count_}; }

 private:
  std::array<PossiblePlace, kMaxCount> places_{};
  size_t count_ = 0;
};

/// Pose that explains the drive, with what else it could have been.
struct FoundPlace {
  PlanarPose pose;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< x, y (m, map frame), yaw (rad)
  double misfit = 0;     ///< mean of independent evidence, in units of its variance
  double elsewhere = 1;  ///< probability that the vehicle is on another street
  double alone = 0;      ///< m driven while that was below `max_elsewhere`, turns included
  bool sure = false;     ///< alone for long, and misfit and sigma are within their limits
};

/// Hypothesis of the global start: a normal distribution of x, y (m), yaw (rad), the scale of the
/// odometry and the error of its yaw rate (rad/s).
struct StreetHypothesis {
  using Matrix = Eigen::Matrix<double, 5, 5>;
  PlanarPose pose;
  int level = StreetGrid::kAnyLevel;  ///< of its street
  double scale = 1;                   ///< true over measured distance
  double yaw_rate_bias = 0;           ///< true minus measured
  Matrix covariance = Matrix::Zero();
  double log_weight = 0;
  double misfit = 0;  ///< sum over independent evidence of the squared distance from the street
};

/// Moves a hypothesis by odometry: `motion` in the vehicle frame within `seconds`; `covariance` of
/// its x, y, yaw.
void predict(StreetHypothesis& hypothesis, const PlanarPose& motion,
             const Eigen::Matrix3d& covariance, double seconds);

/// Compares a hypothesis with the street of its level across it: evidence of which the share
/// `novelty` is independent. Outside the street it loses weight, and its position across the street
/// is corrected.
void compare(StreetHypothesis& hypothesis, const StreetGrid& grid, double novelty,
             const GlobalStartOptions& options);

/// Finds the vehicle on a map from nothing. Hypotheses on all streets in both directions drive by
/// the odometry; those that leave the streets lose weight and are dropped, those that meet are
/// merged. What remains explains the drive: its turns, bends and lengths; where blocks are alike,
/// what the sensors see decides (`weigh`). A place is sure once all others together are improbable
/// for some way, and the drive stayed on its streets: a drive beside the streets of the map may fit
/// one place for a while, but not for long, and seldom through a turn. Where no street fits, the
/// search begins anew. No random numbers; the memory is that of `max_hypotheses`.
class GlobalStart {
 public:
  /// `options.invalid()` must be empty.
  GlobalStart(const SegmentMap& map, const GlobalStartOptions& options);

  /// False if the map is too large, or has no street: there is nothing to search.
  bool possible() const { return !grid_.empty(); }

  /// Begins anew on all streets. Where it was confirmed, the probability is that of the believed
  /// region, and `max_elsewhere` of all other streets together; else streets near the place are
  /// likelier.
  void restart(const std::optional<BelievedPlace>& believed = {});

  /// Moves by odometry, as `predict`.
  void move(const PlanarPose& motion, const Eigen::Matrix3d& covariance, double seconds);

  /// Adds to the log-weight of each hypothesis: `evidence` of what sensors see at its pose.
  void weigh(const std::function<double(const PlanarPose&)>& evidence);

  /// The likeliest place; nothing if no street explains the drive.
  std::optional<FoundPlace> place() const;

  /// Log-weight of the likeliest hypothesis less that of the likeliest one at `pose`; infinite if
  /// none is left there.
  double behind(const PlanarPose& pose) const;

  /// The likeliest hypothesis within `radius` of a pose, m, if it is likelier by more than
  /// `log_odds` than those at the pose, if any; of those that explain the drive up to `max_misfit`:
  /// beside the streets of the map none does.
  std::optional<StreetHypothesis> better_near(const PlanarPose& pose, double radius,
                                              double log_odds, double max_misfit) const;

  /// The places that hypotheses are left at, each of 5 % or more.
  PossiblePlaces possible_places() const;

  int hypotheses() const { return static_cast<int>(hypotheses_.size()); }
  double driven() const { return driven_; }  ///< m since the restart

 private:
  /// Odometry between two comparisons.
  struct Stretch {
    PlanarPose motion;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    double seconds = 0, length = 0;
  };
  /// The hypotheses of one place.
  struct Cluster {
    PlanarPose pose;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    double here = 0, elsewhere = 0;  // sums of weights
  };
  Cluster cluster_about(size_t middle_index, std::span<const PossiblePlace> others) const;
  bool is_among(std::span<const PossiblePlace> places, const PlanarPose& pose) const;
  std::optional<size_t> likeliest(std::span<const PossiblePlace> others) const;
  void weigh_region(const BelievedPlace& believed);
  void spread(double spacing);
  void begin_comparison();
  void go_on_comparing();
  PlanarPose now(size_t hypothesis) const;
  double mean_misfit(const StreetHypothesis& hypothesis) const;
  double half_squared_distance(const StreetHypothesis& hypothesis, const PlanarPose& at,
                               const PlanarPose& pose) const;
  std::optional<FoundPlace> find() const;
  void drop_and_merge();
  void count_alone(bool alone);

  GlobalStartOptions options_;
  StreetGrid grid_;
  std::vector<StreetHypothesis> hypotheses_;
  std::vector<std::pair<uint64_t, uint32_t>> bins_;  // scratch of merging
  Stretch collected_;                                // since the last comparison began
  Stretch compared_;                                 // of the comparison that is going on
  size_t next_ = 0;                                  // hypothesis of that comparison
  double since_merge_ = 0, driven_ = 0, alone_ = 0;  // m
  double turned_ = 0;                                // rad, since the last merge
  std::array<double, 3> turns_{};                    // rad, between the merges before, oldest first
};

}  // namespace infuse::streetmap
