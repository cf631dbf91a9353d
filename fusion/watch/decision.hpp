#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fusion/watch/reestimate.hpp"
#include "fusion/watch/watch.hpp"

namespace infuse::watch {

/// How a calibration stands.
enum class CalibrationState : uint8_t {
  kOk,
  kWatching,       ///< too little seen yet to say anything
  kSuspect,        ///< evidence for a drift, not enough to be certain
  kDrifted,        ///< certain; a re-estimation waits for scenes, or its result for the owner
  kRecalibrating,  ///< a re-estimation runs
  kRecalibrated,   ///< a new calibration is in use and on probation
  kUnusable,       ///< the camera is at fault, or re-estimations keep failing: do not use it
};

/// "OK", "WATCHING" …
const char* to_string(CalibrationState state);

/// What may be done with a re-estimated calibration.
enum class Policy : uint8_t {
  kAlertOnly,    ///< it is proposed; the owner applies it
  kApply,        ///< it is applied
  kApplyWithin,  ///< it is applied where it moved less than the limits, else proposed
};

/// Settings of the decisions.
struct DecisionOptions {
  Policy policy = Policy::kAlertOnly;
  double limit_rotation = 0.05;    ///< rad, of kApplyWithin
  double limit_translation = 0.1;  ///< m, of kApplyWithin
  size_t scenes = 30;              ///< kept since the drift began, before a re-estimation starts
  size_t least_scenes = 15;        ///< the same, where it has been certain for `patience`
  double patience = 40;            ///< s
  double budget = 10;              ///< s of drive after its start at which a result becomes visible
  double least_moved = 3.5;        ///< Mahalanobis distance (6 degrees of freedom) below which the
                                   ///< present calibration is kept after all
  int probation = 15;              ///< looks that a new calibration is compared with the old one
  int failures = 3;                ///< re-estimations without a usable result: unusable
  double retry = 20;               ///< s between re-estimations
  size_t history = 64;             ///< entries kept

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// One thing that happened to a calibration.
struct HistoryEntry {
  Stamp stamp;
  CalibrationState state = CalibrationState::kOk;                    ///< after it
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();  ///< in use after it
  std::string what;  ///< "drifted: rotation about y, 0.52 degrees", "applied", "rolled back: …"
};

/// What is to be done now.
struct Decided {
  CalibrationState state = CalibrationState::kWatching;
  bool changed = false;  ///< the state is another than before
  bool start = false;    ///< start a re-estimation from the scenes kept since `since`
  Stamp since;           ///< of `start`
  bool cancel =
      false;  ///< the re-estimation that runs is of no use any more: `finish` must not come
  bool calibration_changed =
      false;  ///< `Decision::present()` is another: tell the watch and everyone
  bool alternative_changed = false;  ///< `Decision::alternative()` is another: tell the watch
};

/// Decides over one camera's calibration: a state machine in drive time, deterministic. It is told
/// of looks and of results, and says what to do; it does nothing itself.
///
/// OK ⇄ SUSPECT ⇄ DRIFTED by the watch's evidence; DRIFTED → RECALIBRATING once enough scenes were
/// kept since the drift can have begun; a usable result is proposed or applied (policy). After it
/// was applied the old calibration stays as the alternative that every look is compared with: where
/// the dependence on following scenes is not higher than with the old one, it is rolled back. A
/// camera at fault is UNUSABLE and nothing is re-estimated.
class Decision {
 public:
  /// `options.invalid()` must be empty.
  Decision(const Eigen::Isometry3d& T_camera_lidar, const DecisionOptions& options);

  /// After every picture. `scenes`: how many the store holds since `report.since`.
  Decided take(const WatchReport& report, size_t scenes);

  /// The result of the re-estimation that `start` asked for; it becomes visible to the first `take`
  /// at or after the start plus the budget.
  void finish(const Reestimate& result);

  /// What the owner may do; each comes into effect with the next `take`.
  void recalibrate() { asked_recalibrate_ = true; }
  /// Applies the proposal, if there is one.
  void apply() { asked_apply_ = true; }
  /// Back to the calibration before the last.
  void roll_back() { asked_roll_back_ = true; }
  /// Frozen: nothing is applied or re-estimated, and what is being re-estimated is given up; the
  /// watch goes on. The owner may still ask for a re-estimation, which is then proposed.
  void freeze(bool frozen) { asked_frozen_ = frozen; }

  CalibrationState state() const { return state_; }
  const Eigen::Isometry3d& present() const { return present_; }
  const std::optional<Eigen::Isometry3d>& alternative() const { return alternative_; }
  /// Found and not applied.
  const std::optional<Reestimate>& proposal() const { return proposal_; }
  /// Of the present calibration, where it was re-estimated.
  const std::optional<geometry::Matrix6>& covariance() const { return covariance_; }
  bool frozen() const { return frozen_; }
  /// A re-estimation was started and its result is not visible yet.
  bool running() const { return running_; }
  /// Oldest first.
  const std::vector<HistoryEntry>& history() const { return history_; }

 private:
  void obey(const WatchReport& report, Decided& decided);
  void follow_evidence(const WatchReport& report, Decided& decided);
  void maybe_start(const WatchReport& report, size_t scenes, Decided& decided);
  void maybe_finish(const WatchReport& report, Decided& decided);
  void watch_probation(const WatchReport& report, Decided& decided);
  void use(const Eigen::Isometry3d& T, Stamp stamp, const std::string& what, Decided& decided);
  void give_up(Decided& decided);
  void go_back(Stamp stamp, const std::string& why, Decided& decided);
  bool may_apply(const Reestimate& result) const;
  void note(Stamp stamp, std::string what);

  DecisionOptions options_;
  CalibrationState state_ = CalibrationState::kWatching;
  Eigen::Isometry3d present_;
  std::optional<Eigen::Isometry3d> alternative_;  // the one before, while on probation
  std::optional<Eigen::Isometry3d> previous_;     // the one before, for the owner
  std::optional<geometry::Matrix6> covariance_;
  std::optional<Reestimate> proposal_;
  std::optional<Reestimate> result_;  // not visible yet
  bool running_ = false;
  Stamp started_;
  Stamp retry_ = Stamp::earliest();
  Stamp drifted_;  // since when that is certain
  int failed_ = 0;
  double gain_ = 0;
  int gains_ = 0;
  bool asked_recalibrate_ = false, asked_apply_ = false, asked_roll_back_ = false;
  std::optional<bool> asked_frozen_;
  bool frozen_ = false;
  std::vector<HistoryEntry> history_;
};

}  // namespace infuse::watch
