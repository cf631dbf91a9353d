#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <random>
#include <vector>

#include "drivers/measurement/stamp.hpp"
#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/streetmap/label_window.hpp"
#include "fusion/streetmap/local_grid.hpp"
#include "fusion/streetmap/particle_set.hpp"
#include "fusion/streetmap/score_significance.hpp"
#include "fusion/streetmap/tracker_options.hpp"
#include "fusion/streetmap/view_score.hpp"

namespace infuse::streetmap {

/// How sure the tracker is.
enum class TrackState {
  kUnsure,    ///< the pose may be right
  kTracking,  ///< the score cannot be chance, and the particles agree
  kLost,      ///< the pose is not to be used
};

/// "UNSURE", "TRACKING" or "LOST".
const char* name(TrackState state);

/// Where the vehicle is on the map.
struct TrackerEstimate {
  PlanarPose pose;                                           ///< map frame
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< of x, y (m, map frame), yaw (rad)
  TrackState state = TrackState::kLost;
  const char* reason = "";  ///< static text: why the pose is not sure; empty while TRACKING
  double score = 0;         ///< SMI at the pose, last update
  double p_value = 1;       ///< chance that the scores of the last updates are chance
  double z_score = 0;       ///< the scores above their null distribution, in its deviations
  double entropy = 1;       ///< of the particles' weights, 0 … 1
  int particles = 0;

  /// The pose is not lost.
  bool usable() const { return state != TrackState::kLost; }
  Eigen::Isometry3d T_map_vehicle() const;
  /// Order (rx, ry, rz, tx, ty, tz), left perturbation in the map frame; roll, pitch and height are
  /// not estimated: their variances are 0.05² rad² and 1 m².
  geometry::Matrix6 pose_covariance() const;
};

/// Tracks the vehicle on a street map by the dependence between segments and what is seen there,
/// I chapter 3: particles move with the odometry, and are weighed by the SMI between the features
/// of the local grid and the labels that they give its places; the features' side is prepared once
/// for all particles. Weights are exp(sharpness · SMI), where I(3.4) takes SMI itself: in the
/// units of the estimate, one wrong street then costs a particle its life in a few updates.
///
/// A score is compared with those of displaced poses of the same update: they keep the shape of the
/// label image, which labels permuted one by one would not, and so tell the chance that a wrong
/// pose scores as well.
class Tracker {
 public:
  /// The map must outlive the tracker. `options.invalid()` must be empty.
  explicit Tracker(const SegmentMap& map, const TrackerOptions& options = {});

  /// Begins around a pose (map frame); covariance of x, y, yaw.
  void start(const PlanarPose& pose, const Eigen::Matrix3d& covariance);

  /// Begins somewhere within `radius` (m) of a pose, heading within ± `yaw` (rad) of it.
  void search(const PlanarPose& pose, double radius, double yaw);

  /// The vehicle moved by `motion` (frame of the vehicle before it) within `step`; covariance of
  /// x, y, yaw, of errors that are other ones at the next motion. Those that last, of scale and yaw
  /// rate, the particles carry (`ParticleOptions`).
  void predict(const PlanarPose& motion, const Eigen::Matrix3d& covariance, Duration step);

  /// Collects what was seen at the current pose, or where the vehicle was at another moment: `then`
  /// is that pose seen from the current one.
  void add_sweep(const DeskewedView& deskewed, const ImageView* image,
                 const PlanarPose& sensor_pose = {});

  /// Weighs the particles by what was collected. Does nothing before `start`, while too little is
  /// seen, and while the vehicle stands: the same view again is no new evidence.
  void update();

  /// The same with samples that were collected elsewhere (a cache), vehicle frame.
  void update(const GridSamples& samples);

  /// Where the vehicle is; LOST before `start`.
  TrackerEstimate estimate() const;

 private:
  bool begin_update();
  void update_novelty(double distance);
  double window_radius(double spread) const;
  double evaluate(const PlanarPose& pose, const GridSamples& samples,
                  const std::optional<dependence::HyperParameters>& fixed,
                  dependence::HyperParameters* chosen = nullptr);
  void update_weights(const GridSamples& samples);
  void update_significance(const GridSamples& samples);
  void search_globally(const GridSamples& samples);
  void update_state();

  const SegmentMap& map_;
  TrackerOptions options_;
  LocalGrid grid_;
  LabelWindow window_;
  ViewScore view_;
  ParticleSet particles_;
  ScoreSignificance significance_;
  GlobalSearch global_search_;
  std::mt19937_64 random_;
  PlanarPose odometry_;  // of the grid's frame
  bool started_ = false;
  TrackState state_ = TrackState::kLost;
  const char* reason_ = "no initial pose";
  double score_ = 0;
  int updates_since_search_ = 0;
  PlanarPose odometry_at_update_;  // odometry's pose at the last update
  // Since then.
  double driven_s_ = 0;
  double odometry_position_variance_ = 0,
         odometry_yaw_variance_ = 0;  // m², rad² of the odometry's covariance
  double novelty_ = 1;                // share of what is seen that is new
  double mode_novelty_ = 1;           // the same, of what tells one place from another
  double recent_position_variance_ =
      0;  // m²: of what the odometry forgot over the last `fresh` metres

  // Scratch.
  GridSamples samples_;
  std::vector<int32_t> labels_;
  std::vector<double> scores_, null_scores_;
  std::optional<dependence::HyperParameters> last_hyper_parameters_;
};

}  // namespace infuse::streetmap
