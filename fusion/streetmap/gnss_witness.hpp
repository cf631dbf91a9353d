#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

namespace infuse::streetmap {

/// A GNSS fix in the map frame, moved to the time of the particles.
struct MapFix {
  Eigen::Vector2d position{0, 0};  ///< m
  std::optional<double> yaw{};     ///< rad, from the course, where the vehicle is fast enough
  double hdop = 1;                 ///< horizontal dilution of precision; NaN or 0: unknown
};

/// Settings of `GnssWitness`.
struct GnssOptions {
  double map_sigma = 3;          ///< m, standard deviation of the offset of map to world
  double slow_sigma = 3;         ///< m per hdop, of the receiver's error over `correlation_time`
  double noise_sigma = 1.5;      ///< m per hdop, of the error that is new with each fix
  double unknown_hdop = 1.5;     ///< hdop where the receiver states none
  double correlation_time = 30;  ///< s over which the slow error stays the same
  double max_chi_squared = 11;   ///< of an offset that contradicts the pose: 99.6 % of χ² with 2
                                 ///< degrees of freedom
  double doubt_seconds = 3;      ///< s of contradiction until the pose is UNSURE
  double lost_seconds = 15;      ///< s of contradiction until the pose is LOST
  double silent_seconds = 5;     ///< s after a fix while it can propose a place

  /// Returns what is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

/// GNSS as a witness of the pose on the map, never as its source. The offset of fix to pose is a
/// state: a Gauss-Markov process of zero mean, as maps and receivers are metres off and fixes of
/// one minute are off alike. An offset that neither explains is a contradiction. Outliers count
/// less (Huber), and a receiver whose places the map refuted must be further off to contradict
/// again.
class GnssWitness {
 public:
  explicit GnssWitness(const GnssOptions& options) : options_(options) {}

  /// What the fixes say of the pose on the map.
  enum class Verdict { kNone, kDoubt, kLost };

  /// Advances the time by `seconds` of the drive.
  void advance(double seconds);

  /// Adds a fix; `pose` and `variance` (m², worst direction) of the estimate.
  void add(const MapFix& fix, const Eigen::Vector2d& pose, double variance);

  /// Adds a fix while there is no pose that it could witness.
  void add(const MapFix& fix);

  Verdict verdict() const;

  /// Log-likelihood of a position by the last fix, weighted by its share of new evidence; ≤ 0.
  double log_likelihood(const Eigen::Vector2d& position) const;

  /// The same of a position that may be anywhere in `area`, m²: a receiver that is wrong altogether
  /// is there by chance, so that a fix counts the more, the larger that is. `anew`: the
  /// position has not been weighted by any fix yet, so that all of this one is new evidence.
  double log_likelihood_in(double area, const Eigen::Vector2d& position, bool anew) const;

  /// Log-odds of a position against that of the estimate, by the offset of the fixes of the last
  /// seconds; 0 without fixes.
  double log_odds(const Eigen::Vector2d& position, const Eigen::Vector2d& estimate) const;

  /// Position of the vehicle by the fixes, given the pose of the estimate: only while they are
  /// recent. `sigma` is its standard deviation, m.
  struct Place {
    Eigen::Vector2d position;
    std::optional<double> yaw;
    double sigma = 0;
  };
  std::optional<Place> place(const Eigen::Vector2d& pose) const;

  /// Offset of the fixes from the pose on the map, m; nothing before the first fix.
  std::optional<Eigen::Vector2d> offset() const;
  double offset_sigma() const;

  /// The pose on the map begins anew: its offset is unknown. `refuted`: after a contradiction.
  void restart(bool refuted);

 private:
  double prior_variance() const;
  bool is_silent() const { return now_ - last_fix_ > options_.silent_seconds; }

  GnssOptions options_;
  double now_ = 0;              // s
  double last_fix_ = -1e9;      // s
  double agreed_since_ = 0;     // s
  double contradicts_for_ = 0;  // s
  double hdop_ = 1;
  double worth_ = 1;         // factor of the standard deviation, ≥ 1
  double new_evidence_ = 0;  // share of the last fix
  bool contradicts_ = false;
  MapFix fix_;
  Eigen::Vector2d offset_{0, 0};
  double offset_variance_ = -1;  // below 0: unknown
  double track_variance_ = 0;
};

}  // namespace infuse::streetmap
