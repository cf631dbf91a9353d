#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <random>
#include <vector>

#include "drivers/measurement/stamp.hpp"
#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/streetmap/global_start.hpp"
#include "fusion/streetmap/gnss_witness.hpp"
#include "fusion/streetmap/label_window.hpp"
#include "fusion/streetmap/local_grid.hpp"
#include "fusion/streetmap/particle_set.hpp"
#include "fusion/streetmap/place_check.hpp"
#include "fusion/streetmap/score_significance.hpp"
#include "fusion/streetmap/tracker_options.hpp"
#include "fusion/streetmap/view_score.hpp"

namespace infuse::streetmap {

/// State of the tracker.
enum class TrackState {
  kUnsure,    ///< the pose may be right: its region follows odometry
  kTracking,  ///< the place is confirmed, nothing doubts it, and the particles agree
  kLost,      ///< evidence contradicts the pose, or there is none: it must not be used
};

/// Returns "UNSURE", "TRACKING" or "LOST".
const char* name_of(TrackState state);

/// Pose of the vehicle on the map.
struct TrackerEstimate {
  PlanarPose pose;                                           ///< map frame
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< of x, y (m, map frame), yaw (rad)
  TrackState state = TrackState::kLost;                      ///< how far it can be trusted
  const char* reason = "";  ///< static text: why the pose is not certain; empty while TRACKING
  double score = 0;         ///< SMI at the pose, last update
  double p_value = 1;       ///< p-value of the scores of the last updates
  double z_score = 0;       ///< mean z-score of the last updates against the null distribution
  double entropy = 1;       ///< normalised entropy of the weights, 0 … 1
  double elsewhere = 1;     ///< probability that the true place is another one that was checked
  /// GNSS fixes minus the pose on the map, m, map frame; nothing without fixes.
  std::optional<Eigen::Vector2d> gnss_offset{};
  double gnss_offset_sigma = 0;   ///< m
  bool gnss_contradicts = false;  ///< fixes contradict the pose, for some seconds
  bool on_map = false;            ///< the pose lies on the map
  int updates = 0;                ///< views that were compared with the map since the start
  int particles = 0;              ///< number of particles
  int hypotheses = 0;             ///< of the search on all streets; 0: there is none at present

  /// True unless the track is lost.
  bool usable() const { return state != TrackState::kLost; }
  /// The pose in space, on the ground.
  Eigen::Isometry3d T_map_vehicle() const;
  /// Order (rx, ry, rz, tx, ty, tz), left perturbation in the map frame. Roll, pitch and height are
  /// not estimated: their variances are 0.05² rad² and 1 m².
  geometry::Matrix6 pose_covariance() const;
};

/// Tracks the vehicle on a street map by the dependence between map segments and sensor data, I
/// chapter 3: a particle filter that predicts with the odometry and weights each particle by the
/// SMI between the features of the local grid and the map labels at that pose. The feature side is
/// prepared once for all particles. Weights are exp(sharpness · SMI) where I(3.4) uses SMI itself:
/// in SMI units alone a wrong street would lower a weight too slowly.
///
/// The score is compared with the scores of displaced poses of the same update. These keep the
/// spatial structure of the label image, which a permutation of labels would destroy, so they give
/// the probability that a wrong pose scores as high.
///
/// The want of evidence loses nothing: what was confirmed follows odometry, whose covariance widens
/// the region until the map narrows it again, on the map and beside it. LOST is for contradiction:
/// by GNSS fixes for long, or of a start that was never confirmed by the drive and the sensors
/// together.
///
/// Without a start, while a place is not confirmed and when LOST, `GlobalStart` searches all
/// streets. Once few places are left, the sensors witness which it is. Once one place alone fits
/// the drive, the tracker starts there, unless it is there.
class Tracker {
 public:
  /// `map` must outlive the tracker. `options.invalid()` must be empty. `score` weights the poses;
  /// null: `LsmiScore`.
  explicit Tracker(const SegmentMap& map, const TrackerOptions& options = {},
                   std::unique_ptr<ViewScore> score = nullptr);

  /// Starts around a pose (map frame); covariance of x, y, yaw.
  void start(const PlanarPose& pose, const Eigen::Matrix3d& covariance);

  /// Predicts by a motion (in the vehicle frame before it) within `step`. The covariance (x, y,
  /// yaw) is that of errors that are independent between motions; persistent errors of scale and
  /// yaw rate are part of the particles (`ParticleOptions`).
  void predict(const PlanarPose& motion, const Eigen::Matrix3d& covariance, Duration step);

  /// Adds a deskewed sweep and an optional image taken at `sensor_pose`, relative to the current
  /// pose.
  void add_sweep(const DeskewedView& deskewed, const ImageView* image,
                 const PlanarPose& sensor_pose = {});

  /// Weights the particles by the collected data. Does nothing before a start and with too few
  /// samples. While odometry stands the same view is no new evidence, and only judged: what matched
  /// when it stopped must go on to match, or else the vehicle is carried.
  void update();

  /// The same with samples from elsewhere (a cache), vehicle frame.
  void update(const GridSamples& samples);

  /// Adds a GNSS fix, moved to the time of the particles: a weight of particles and of the search
  /// of all streets, and a judgement that goes on while the vehicle stands.
  void add_fix(const MapFix& fix);

  /// True once it has a place on the map, which may be wrong.
  bool started() const { return started_; }

  /// Returns the current estimate; LOST before a start.
  TrackerEstimate estimate() const;

  /// The places where the vehicle may be, each with its probability: those of the particles where
  /// they are two, else those that the search of all streets has left; none while TRACKING.
  PossiblePlaces possible_places() const;

  /// The pose hypotheses; none before a start.
  std::span<const Particle> particles() const {
    return started_ ? particles_.all() : std::span<const Particle>();
  }

 private:
  static constexpr const char* kDisagreement = "the particles do not agree";
  static constexpr double kMaxSpread = 20;  // m, derived from LocalGridOptions::extent: half of it

  void search_streets(const PlanarPose& motion, const Eigen::Matrix3d& covariance, Duration step);
  void begin_search();
  void search_region();
  double proposal_radius() const;
  bool agrees(const FoundPlace& found) const;
  void use_found_street();
  bool judges_streets() const;
  bool fits_another_street(const PlanarPose& pose) const;
  bool is_refuted_start(const PlanarPose& pose) const;
  void witness_streets_by_fix();
  bool begin_witness();
  void witness_streets(const GridSamples& samples);
  bool begin_update();
  void update_novelty(double distance);
  double window_radius(double spread) const;
  void read_windows(const PoseMoments& likelier);
  const LabelWindow& window_at(const PlanarPose& pose) const;
  double evaluate(const LabelWindow& window, const PlanarPose& pose, const GridSamples& samples,
                  const std::optional<dependence::HyperParameters>& fixed,
                  dependence::HyperParameters* chosen = nullptr);
  void update_weights(const GridSamples& samples);
  void add_score(const GridSamples& samples, ScoreSignificance& significance);
  void judge_standing(const GridSamples& samples);
  void search_globally(const GridSamples& samples);
  void check_place(const GridSamples& samples, const PlanarPose& before);
  bool propose_street(const PlanarPose& pose);
  void update_state();
  bool is_doubted() const;
  Eigen::Matrix2d position_covariance(const PoseMoments& moments) const;
  bool particles_agree(const PoseMoments& moments) const;
  void propose_fix(const PlanarPose& estimate);

  const SegmentMap& map_;
  TrackerOptions options_;
  LocalGrid grid_;
  LabelWindow window_, second_window_, wide_window_;  // around the particles, those of the less
                                                      // likely mode, the other places
  PlanarPose window_middle_;
  std::optional<PlanarPose> second_middle_;  // nothing: one mode
  std::unique_ptr<ViewScore> view_;
  ParticleSet particles_;
  ScoreSignificance significance_, standing_significance_;
  std::optional<double> z_when_it_stopped_;  // of its first views
  GlobalSearch global_search_;
  std::optional<GlobalStart> global_start_;  // nothing: not wanted, or impossible on this map
  bool searching_streets_ = false;
  bool region_searched_ = false;              // since the place was sure: it was lost from sight
  double searched_ = 0;                       // m driven since that began
  double driven_at_fix_ = INFINITY;           // m, of the search, at the last fix
  double witnessed_m_ = 0, witnessed_s_ = 0;  // driven since its hypotheses were last witnessed
  PlaceCheck place_check_;
  GnssWitness gnss_;
  std::mt19937_64 random_;
  PlanarPose odometry_;                           // pose of the vehicle in the frame of the grid
  bool started_ = false, was_confirmed_ = false;  // since the start
  TrackState state_ = TrackState::kLost;
  const char* reason_ = "no initial pose";
  double score_ = 0;
  int updates_since_start_ = 0, updates_since_proposal_ = 0;
  PlanarPose odometry_at_update_;  // odometry pose at the last update
  double driven_s_ = 0;
  double odometry_position_variance_ = 0,
         odometry_yaw_variance_ = 0;  // m², rad² of the odometry
  double novelty_ = 1;                // share of the view that is new evidence
  double mode_novelty_ = 1;           // the same for evidence between two modes
  double recent_position_variance_ =
      0;  // m²: odometry variance over the last `novelty_distance` metres

  // Scratch.
  GridSamples samples_;
  std::vector<int32_t> labels_;
  std::vector<double> scores_, null_scores_;
  std::optional<dependence::HyperParameters> last_hyper_parameters_;
};

}  // namespace infuse::streetmap
