#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fusion/streetmap/street_seeds.hpp"

namespace infuse::streetmap {

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

/// Finds the vehicle on a map from nothing. Hypotheses on all streets in both directions drive by
/// the odometry; those that leave the streets lose weight and are dropped, those that meet are
/// merged. What remains explains the drive: its turns, bends and lengths; where blocks are alike,
/// what the sensors see decides (`weigh`). A place is sure once all others together are improbable
/// for some way, and the drive stayed on its streets: a drive beside the streets of the map may fit
/// one place for a while, but not for long, and seldom through a turn. Where no street fits, the
/// search begins anew. On a large map it begins with the places that fit the first turns
/// (`StreetSeeds`), or around where the vehicle is believed. No random numbers; the memory is that
/// of `max_hypotheses`.
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

  /// Number of hypotheses; on a large map all that there may be, until it has turned.
  int hypotheses() const {
    return seeding_ ? options_.max_hypotheses : static_cast<int>(hypotheses_.size());
  }
  double driven() const { return driven_; }  ///< m since the restart

 private:
  /// Cells of the grid, without the last row and column.
  struct Cells {
    int left = 0, low = 0, right = 0, high = 0;
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
  Cells everywhere() const;
  Cells near(const PlanarPose& pose, double reach) const;
  bool spread_near(const PlanarPose& pose);
  std::optional<double> spread_in(const Cells& cells);
  void spread(const Cells& cells, double spacing);
  void seed(int comparisons);
  bool begin_comparison();
  void go_on_comparing(int comparisons);
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
  std::optional<double> spacing_;     // m, of hypotheses on all streets; nothing: they are too many
  std::optional<StreetSeeds> seeds_;  // then
  bool seeding_ = false;
  std::vector<DriveStretch> pending_;  // of the drive, after the comparison that is going on
  DriveStretch collected_;             // since
  DriveStretch compared_;              // of the comparison that is going on
  size_t next_ = 0;                    // hypothesis of that comparison
  double since_merge_ = 0, driven_ = 0, alone_ = 0;  // m
  double turned_ = 0;                                // rad, since the last merge
  std::array<double, 3> turns_{};                    // rad, between the merges before, oldest first
};

}  // namespace infuse::streetmap
