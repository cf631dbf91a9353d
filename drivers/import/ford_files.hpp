#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/import/mat_file.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::importers {

/// Stamps of images (Timestamp.log): of each line the number that can be a time in µs since 1970.
/// Lines without one are counted in a note.
std::vector<Stamp> parse_ford_stamps(std::string_view text, const std::string& name,
                                     std::vector<Error>& notes);

/// A camera of PARAM.mat.
struct FordCamera {
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< pixels, of the undistorted image
  Eigen::Isometry3d T_camera_velodyne = Eigen::Isometry3d::Identity();
};

/// The cameras of PARAM.mat. Fails unless each has K, R and t that make sense.
Result<std::vector<FordCamera>> read_ford_cameras(const std::map<std::string, MatArray>& variables,
                                                  const std::string& name);

/// A pose of the body frame in the local frame.
struct FordPose {
  Stamp stamp;
  Eigen::Isometry3d T_local_body = Eigen::Isometry3d::Identity();
  double forward_speed = 0;  ///< m/s; NaN if it is not known
};

/// The pose of a scan file (SCANS): timestamp_laser and X_wv. Fails if they are not there, or the
/// angles cannot be radians.
Result<FordPose> read_ford_scan(const std::map<std::string, MatArray>& variables,
                                const std::string& name);

/// The poses of the inertial system (Pose-Applanix): utime, pos, rph and vel. Fails unless all are
/// there with one column or row for each time.
Result<std::vector<FordPose>> read_ford_poses(const std::map<std::string, MatArray>& variables,
                                              const std::string& name);

/// Width and height of a binary PPM or PGM image, and where its pixels begin.
struct PnmHeader {
  int width = 0, height = 0;
  bool colour = false;
  size_t pixels = 0;  ///< offset, bytes
};

/// Reads the header of a binary PPM or PGM image of 8 bits; nothing for other files and for those
/// that are shorter than their pixels.
std::optional<PnmHeader> read_pnm_header(std::string_view file);

}  // namespace infuse::importers
