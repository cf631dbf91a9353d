#pragma once

#include <cstdint>
#include <iosfwd>
#include <random>
#include <string>
#include <vector>

#include "fusion/calibration/calibrate.hpp"
#include "fusion/calibration/scene.hpp"
#include "fusion/calibration/visible_points.hpp"
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

  /// Within 0.2 degrees and 5 cm of the truth.
  bool right() const;
};

/// Errors and stated uncertainty of a calibration; what was calibrated is left open.
RigTrial judge(const calibration::CalibrationResult& result,
               const Eigen::Isometry3d& T_camera_lidar);

/// Draws errors of intrinsics as a careful calibration leaves them: as the defaults assume.
void draw_known_errors(CameraIntrinsics& camera, std::mt19937_64& random);

/// Draws the error of the clock between images and sweeps: as the defaults assume.
void draw_known_errors(std::vector<RigScene>& scenes, std::mt19937_64& random);

/// Makes scenes with the features of the default measure; `initial` directs edges along the rings.
std::vector<calibration::Scene> make_scenes(const std::vector<RigScene>& recorded,
                                            const calibration::RigCamera& camera,
                                            const Eigen::Isometry3d& initial);

/// Which trials are made of a rig.
enum class TrialSet {
  kTrust,       ///< one right, one with a fault, by the rig's seed
  kUnmeasured,  ///< right, and cy 15 px off; each with stated intrinsics, and with others
  kCells,       ///< right ones of 3 to 40 scenes, diverse and neighbouring
};

/// Calibrates a recording from an initial pose that is up to 2 degrees and 8 cm off about and along
/// every axis. `details`, where not null, gets the parts of each stated covariance.
std::vector<RigTrial> try_rig(const RigRecording& recording, uint64_t seed, TrialSet set,
                              std::ostream* details = nullptr);

void write_header(std::ostream& out);
void write_row(std::ostream& out, const RigTrial& trial);

/// Reads rows that were written before; leaves out the header and incomplete rows.
std::vector<RigTrial> read_rows(std::istream& in);

/// Writes tables by kind, and of the right ones by lidar and by camera: how many are usable and
/// surely wrong, the mean squared Mahalanobis error divided by 6 of the usable ones, how many of
/// these lie inside the 95 % region, and what the others are refused for.
void write_summary(std::ostream& out, const std::vector<RigTrial>& trials);

}  // namespace infuse::study
