#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

#include "tests/study/rigs/rig_recording.hpp"

namespace infuse::study {

/// One calibration of a rig drawn at random.
struct RigTrial {
  uint64_t seed = 0;  ///< of the rig
  std::string kind;   ///< "right", or what is wrong
  std::string lidar;
  int width = 0, height = 0;
  bool fisheye = false;
  size_t scenes = 0;
  double effective_scenes = 0;
  bool usable = false;
  std::string reason;
  double rotation_error = 0, translation_error = 0;  ///< rad, m
  double rotation_sigma = 0, translation_sigma = 0;  ///< rad, m: the largest of the axes
  double mahalanobis_squared = 0;                    ///< of the error, by the stated covariance
  double scenes_mahalanobis_squared = 0;             ///< by the covariance from the scenes alone
  double cpu_s = 0;

  /// Used although it is wrong, and far beyond what it states: more than 0.2 degrees or 5 cm off,
  /// and outside the 99.7 % region.
  bool surely_wrong() const;
};

/// Calibrates a recording rightly and with every kind of fault, from an initial pose that is up to
/// 2 degrees and 8 cm off about and along every axis.
std::vector<RigTrial> try_rig(const RigRecording& recording, uint64_t seed, bool quick);

void write_header(std::ostream& out);
void write_row(std::ostream& out, const RigTrial& trial);

/// Writes, per kind and number of scenes: how many are usable, surely wrong, and the mean squared
/// Mahalanobis error divided by 6 of the usable ones.
void write_summary(std::ostream& out, const std::vector<RigTrial>& trials);

}  // namespace infuse::study
