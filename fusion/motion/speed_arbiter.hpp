#pragma once

#include <array>

#include "fusion/motion/odometry_sources.hpp"

namespace infuse::motion {

/// Decides which of the sources of the speed is wrong when they contradict each other: by votes,
/// and by what a vehicle can do. Pure.
///
/// Each source claims a speed with its error. Right is the claim with the least cost: half its
/// change since the sources agreed, squared, in units of what a vehicle can accelerate, plus that
/// of its difference to each other claim, bounded, since a source may be wrong by any amount. What
/// is beyond the bound is out, until it agrees again or has moved as a vehicle does for longer than
/// faults of its kind last.
class SpeedArbiter {
 public:
  /// What one sample of a source says.
  struct Claim {
    Stamp stamp = Stamp::earliest();
    double speed = 0;  ///< m/s, of the vehicle
    double error = 0;  ///< m/s: `speed` minus that of the state, which time does not change
    double sigma = 0;  ///< m/s, standard deviation
    double jump = 0;  ///< m/s: the part of the change since the sample before that no vehicle makes
  };

  /// When two sources last agreed, and on which speeds.
  struct Agreement {
    Stamp stamp = Stamp::earliest();
    std::array<double, kOdometrySources>
        speed{};  ///< m/s, by `OdometrySource`; NaN: not one of them
  };

  explicit SpeedArbiter(const OdometryOptions& options) : options_(options) {}

  /// Adds a sample. `lasts`: how long faults of the source last at most, latest for no limit.
  void add(OdometrySource source, const Claim& claim, Duration lasts);

  /// Notes that a sample corrected the speed of the state, to which claims are relative, m/s.
  void correct(double change);

  /// Decides between the claims, of which that of `source` contradicts the state: those that are
  /// wrong are out. Returns false if that of `source` is.
  bool judge(OdometrySource source);

  /// Puts a source out until a sample after `lasts`.
  void put_out(OdometrySource source, Stamp now);

  bool is_out(OdometrySource source) const { return at(source).out; }
  const Agreement& agreement() const { return agreement_; }

  /// Forgets all claims; what is out is in.
  void reset();

  /// Part of a change of the speed that no vehicle makes in `seconds`, beyond `tolerance`; m/s.
  static double impossible(double change, double seconds, double tolerance);

 private:
  struct Record {
    Claim claim;
    double jumped = 0, furthest = 0;  // m/s: sum of its jumps, and its largest
    bool out = false;
    Stamp since = Stamp::earliest();  // out, or the last jump while out

    void readmit() {
      jumped = furthest = 0;
      out = false;
    }
  };
  Record& at(OdometrySource source) { return records_[static_cast<size_t>(source)]; }
  const Record& at(OdometrySource source) const { return records_[static_cast<size_t>(source)]; }
  bool is_recent(OdometrySource source, Stamp now) const;
  bool takes_part(OdometrySource source, Stamp now) const;
  double cost(OdometrySource source, Stamp now) const;
  double sigmas_apart(OdometrySource a, OdometrySource b) const;
  void agree(OdometrySource source, Stamp since);

  OdometryOptions options_;
  std::array<Record, kOdometrySources> records_;
  Agreement agreement_;
};

}  // namespace infuse::motion
