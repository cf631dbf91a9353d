#pragma once

#include <optional>
#include <span>
#include <string>

#include "fusion/mapping/keyframe_submaps.hpp"
#include "fusion/places/place_matcher.hpp"

namespace infuse::places {

/// Settings of the localisation on a map (decision 17).
struct LocaliserOptions {
  mapping::KeyframeOptions keyframes{.distance = 4, .rotation = 0.4};  ///< what is compared with
                                                                       ///< the map, so often
  mapping::SubmapOptions submaps;                                      ///< of what was seen
  PlaceMatcherOptions matcher;                                         ///< of places
  /// Probability of a place that is recognised without a guess, and that what was seen since then
  /// confirms it: the error probability of Wald's sequential test is one in a thousand either
  /// way (decision 12).
  double min_probability = 0.999;
  size_t standing_sweeps = 10;  ///< a search that has seen so many sweeps need not wait for motion
  double confirm_distance = 8;  ///< m from where a place was recognised to where it is confirmed
  double max_unconfirmed = 60;  ///< m without one; then the pose is UNSURE …
  double lost_after = 150;      ///< m; … and then LOST
  double max_sigma = 2;         ///< m, of the position; beyond it the pose is LOST
  double gate = 5;              ///< standard deviations; beyond are one in 10⁶ of a Gaussian's

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// How far the pose on the map can be trusted.
enum class LocaliserState : uint8_t {
  kLost,      ///< the pose is not known
  kUnsure,    ///< recognised, not yet confirmed, or no longer
  kTracking,  ///< confirmed by two places of the map, and registered to it
};

/// Returns "LOST", "UNSURE" or "TRACKING".
const char* name_of(LocaliserState state);

/// Where the vehicle is on the map, as of a sweep.
struct LocaliserPose {
  Stamp stamp;                                                      ///< of the sweep
  LocaliserState state = LocaliserState::kLost;                     ///< how far it can be trusted
  Eigen::Isometry3d T_map_vehicle = Eigen::Isometry3d::Identity();  ///< the pose
  /// Right perturbation in the vehicle frame, (rx, ry, rz, tx, ty, tz), rad and m.
  geometry::Matrix6 covariance = geometry::Matrix6::Zero();
  const char* reason = "no sweep yet";  ///< static text; empty while TRACKING
  PlaceProbabilities place;             ///< of the last search, which a recognised place ends
  bool verified = false;                ///< the map confirmed it at this sweep

  bool usable() const { return state == LocaliserState::kTracking; }  ///< it may be used
};

/// Finds a vehicle on a map of keyframes from nothing, and tracks it there. Submaps of what the
/// lidar saw in the last metres are compared with the places of the map by their shape; the most
/// alike are verified by registration both ways and by what each view refutes of the other; a
/// place that another fits as well is not accepted. From then on every submap is compared with the
/// nearest place: how well it fits is evidence for or against the pose (Wald's sequential
/// probability ratio test, by the log odds of `PlaceFit`), and where verification accepts it, it
/// corrects the pose; between them odometry carries it. The pose is TRACKING once the evidence of
/// other places than the first one is as sure as recognition has to be, UNSURE where it speaks
/// against the pose, and LOST where it does so as surely.
class Localiser {
 public:
  /// `options.invalid()` must be empty; `map.descriptors` has as many entries as keyframes.
  Localiser(PlaceMap map, const Eigen::Isometry3d& T_vehicle_lidar,
            const LocaliserOptions& options = {});

  /// Adds a sweep, deskewed to `motion.stamp` (lidar frame, m). Returns the pose as of then, or why
  /// the map cannot be read.
  Result<LocaliserPose> add(const geometry::PointsView& points, std::span<const float> reflectivity,
                            const mapping::SweepMotion& motion);

 private:
  std::optional<mapping::KeyframeSubmap> next_query(const geometry::PointsView& points,
                                                    std::span<const float> reflectivity,
                                                    const mapping::SweepMotion& motion);
  Result<void> search(const mapping::KeyframeSubmap& query);
  Result<void> check(const mapping::KeyframeSubmap& query);
  void predict(const mapping::SweepMotion& motion, const Eigen::Isometry3d& T_from_to,
               double seconds);
  bool update(const MatchedPlace& measured, const Eigen::Isometry3d& T_measured_now);
  void begin_at(const MatchedPlace& found, const mapping::KeyframeSubmap& query);
  void weigh(double log_odds);
  double evidence_limit() const;
  void lose(const char* reason);
  void judge();

  LocaliserOptions options_;
  PlaceMatcher matcher_;
  mapping::KeyframeSubmaps submaps_;
  LocaliserPose pose_;
  double recognised_way_ = 0;  // m, where the pose began
  double confirmed_way_ = 0;   // m, of the last verification that succeeded
  double evidence_ = 0;        // log odds of the pose by what was seen since it began, limited
  bool confirmed_ = false;
  const char* mismatch_ = "";  // why the last verification failed
};

}  // namespace infuse::places
