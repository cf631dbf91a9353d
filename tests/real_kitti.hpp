#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "drivers/measurement/sweep.hpp"

/// Files of KITTI's layouts, as the tests on real recordings read them.
namespace infuse::kitti {

/// Coordinates of a sweep's returns; their times are not set.
inline Sweep read_sweep(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(stream)), {});
  Sweep sweep;
  sweep.resize(bytes.size() / 16);
  for (size_t i = 0; i < sweep.size(); ++i) {
    float point[3];
    std::memcpy(point, &bytes[16 * i], sizeof(point));
    sweep.x[i] = point[0], sweep.y[i] = point[1], sweep.z[i] = point[2];
  }
  return sweep;
}

/// Poses of a file with twelve numbers a line; other lines are left out.
inline std::vector<Eigen::Isometry3d> read_poses(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::vector<Eigen::Isometry3d> poses;
  for (std::string line; std::getline(stream, line);) {
    std::istringstream numbers(line.substr(line.find(':') + 1));
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    for (int i = 0; i < 12; ++i) numbers >> T.matrix()(i / 4, i % 4);
    if (numbers) poses.push_back(T);
  }
  return poses;
}

/// Seconds of the day in lines such as "2011-09-26 13:04:32.351950336".
inline std::vector<double> read_stamps(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::vector<double> stamps;
  for (std::string line; std::getline(stream, line);) {
    int hours = 0, minutes = 0;
    double seconds = 0;
    std::sscanf(line.c_str(), "%*s %d:%d:%lf", &hours, &minutes, &seconds);
    stamps.push_back(3600 * hours + 60 * minutes + seconds);
  }
  return stamps;
}

/// A drive of the raw layout with the poses of its lidar at the middles of the sweeps.
struct RawDrive {
  std::vector<Sweep> sweeps;  ///< with the times of returns
  std::vector<Eigen::Isometry3d> truth;
};

/// Reads drive 0009 in `folder` (`drives/kitti_raw_0009` of the real recordings). The sensor turns
/// clockwise from the rear: the azimuth of a return gives its time.
inline RawDrive read_raw_0009(const std::filesystem::path& folder) {
  RawDrive out;
  const auto drive = folder / "2011_09_26/2011_09_26_drive_0009_sync/velodyne_points";
  out.truth = read_poses(folder / "poses_velodyne_from_oxts_velocity.txt");
  const auto begins = read_stamps(drive / "timestamps_start.txt");
  const auto ends = read_stamps(drive / "timestamps_end.txt");
  for (size_t k = 0; k < out.truth.size() && k < begins.size() && k < ends.size(); ++k) {
    char name[32];
    std::snprintf(name, sizeof(name), "data/%010zu.bin", k);
    if (!std::filesystem::exists(drive / name)) break;
    Sweep sweep = read_sweep(drive / name);
    sweep.stamp = Stamp::from_ns(0) + from_seconds(begins[k]);
    sweep.span = from_seconds(ends[k] - begins[k]);
    for (size_t i = 0; i < sweep.size(); ++i) {
      const double turn = 0.5 - std::atan2(sweep.y[i], sweep.x[i]) / (2 * std::numbers::pi);
      sweep.time_offset_ns[i] =
          static_cast<int32_t>(turn * static_cast<double>(sweep.span.count()));
    }
    out.sweeps.push_back(std::move(sweep));
  }
  return out;
}

/// Raises every return by 0.205°: the vertical angles of KITTI's calibration are said to be off by
/// as much.
inline void correct_vertical_angle(Sweep& sweep) {
  constexpr float kAngle = 0.205F * std::numbers::pi_v<float> / 180;
  const float c = std::cos(kAngle), s = std::sin(kAngle);
  for (size_t i = 0; i < sweep.size(); ++i) {
    const float across = std::hypot(sweep.x[i], sweep.y[i]);
    if (!(across > 0)) continue;
    const float scale = (c * across - s * sweep.z[i]) / across;
    sweep.z[i] = s * across + c * sweep.z[i];
    sweep.x[i] *= scale;
    sweep.y[i] *= scale;
  }
}

}  // namespace infuse::kitti
