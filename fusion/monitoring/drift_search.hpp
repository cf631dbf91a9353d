#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>
#include <stop_token>

#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/monitoring/axis.hpp"
#include "fusion/monitoring/delay_ambiguity.hpp"
#include "fusion/monitoring/monitor_dependence.hpp"

namespace infuse::monitoring {

/// What explains a drift by itself: a displacement along one axis of a pose, or late stamps.
inline constexpr size_t kSingleAxes = 7;  ///< six degrees of freedom, and the time of the image

/// Where the dependence of some scenes leads to.
struct DriftEstimate {
  geometry::Vector6 moved = geometry::Vector6::Zero();  ///< from the pose of the search, rad and m
  geometry::Matrix6 covariance = geometry::Matrix6::Zero();  ///< of `moved`
  bool at_least = false;  ///< the best pose lies at the border of what was searched
  double delay = 0;       ///< s; the best delay of the stamps, if the pose is right
  /// Nats gained by each axis alone; their differences are logarithms of odds.
  std::array<double, kSingleAxes> gain{};

  /// Returns the axis that explains most by itself.
  Axis likeliest() const;
};

/// Searches the pose of a camera in its last scenes, after a knock of any size: all rotations of
/// some degrees with blurred images, then the best ones more and more finely in all six axes. Pure;
/// allocates nothing once it has held and searched as many scenes as it keeps.
class DriftSearch {
 public:
  explicit DriftSearch(const MonitorDependence::Weights& weights) : dependence_(weights) {}

  /// Adds the scene of an evaluation; the oldest makes room for it.
  void add(const ComparedPlanes& planes, const ComparedReturns& returns, const Motion& motion);

  /// Searches around `T_camera_lidar` in the last `scenes`, at most `kScenes` and as many as were
  /// added; only near the calibration and near `known` if that is given. `noise`: what the sum of
  /// dependence is divided by to be a log-likelihood, nats. Returns soon after a stop was
  /// requested; the result is then meaningless.
  DriftEstimate find(const Eigen::Isometry3d& T_camera_lidar,
                     const std::optional<geometry::Vector6>& known, size_t scenes, double noise,
                     const geometry::CameraModel& camera, const std::stop_token& stop = {});

  static constexpr size_t kScenes = 8;  ///< that are kept (decision 17)

 private:
  struct Scene {
    ComparedPlanes fine, blurred;  ///< blurred by a search without a known pose
    ComparedReturns returns;
    Motion motion;
  };
  struct Candidate {
    geometry::Vector6 moved = geometry::Vector6::Zero();
    double nats = 0;
  };
  enum class Detail : uint8_t { kBlurred, kFine };
  const Scene& recent(size_t back) const { return scenes_[(next_ - 1 - back) % kScenes]; }
  double value_at(const geometry::Vector6& moved, Detail detail);
  double value_late(double delay);
  void collect_candidates(const std::optional<geometry::Vector6>& known);
  void keep_if_better(const Candidate& candidate);
  void climb(Candidate& candidate, Detail detail, double rotation, double translation);
  Candidate refine_best(bool known);
  /// The log-likelihood near a pose.
  struct Parabola {
    geometry::Matrix6 information;  // minus the second derivatives
    geometry::Vector6 slope;
  };
  void try_translations(Candidate& best);
  Parabola parabola_at(const geometry::Vector6& moved);
  geometry::Matrix6 climb_ridge(Candidate& best);
  void compare_axes(const geometry::Vector6& moved, const geometry::Matrix6& information,
                    DriftEstimate& estimate);

  MonitorDependence dependence_;
  PlaneBlur blur_;
  std::array<Scene, kScenes> scenes_;
  size_t next_ = 0;
  // Of the present search.
  Eigen::Isometry3d T_camera_lidar_ = Eigen::Isometry3d::Identity();
  const geometry::CameraModel* camera_ = nullptr;
  std::stop_token stop_;
  size_t count_ = 0;
  double noise_ = 1;
  static constexpr size_t kCandidates = 5;  ///< peaks that are kept (decision 17)
  std::array<Candidate, kCandidates> candidates_;
  size_t candidate_count_ = 0;
};

}  // namespace infuse::monitoring
