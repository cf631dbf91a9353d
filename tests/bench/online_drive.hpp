#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/pipeline/lidar_intake.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "drivers/camera/colour.hpp"
#include "drivers/camera/image_decoder.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/recording/drive_toml.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "fusion/geometry/trajectory.hpp"
#include "fusion/motion/deskew.hpp"

/// Drive on disk as seen by the calibration monitor: images, and sweeps deskewed to their exposure
/// with the true trajectory.
namespace infuse::online {

/// An image with its sweep.
struct ImageSweepPair {
  CameraFrame grey;
  Sweep sweep;                                             ///< x, y, z at the time of the exposure
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();  ///< rad/s, camera axes
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      ///< m/s, camera axes
};

/// The camera and its true pose.
struct Truth {
  CameraIntrinsics intrinsics;
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();
};

/// All pairs and the truth.
struct Drive : Truth {
  std::vector<ImageSweepPair> pairs;
};

inline std::optional<CameraFrame> read_grey(const std::filesystem::path& path, Stamp stamp) {
  std::ifstream stream(path, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(stream), {}};
  CameraFrame frame;
  const std::span<const uint8_t> file(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
  if (!camera::decode_image(file, {.grey = true}, frame)) return std::nullopt;
  frame.stamp = stamp;
  if (frame.format == PixelFormat::kGrey8) return frame;
  CameraFrame grey;
  camera::to_grey(frame, grey);
  return grey;
}

/// Reads a drive with one lidar and one camera and calls `callback(const Truth&, ImageSweepPair&)`
/// for each pair. Without a true trajectory the sweeps are not deskewed. Returns false if there is
/// no such drive.
template <class Callback>
bool for_each_pair(const std::filesystem::path& folder, const Callback& callback) {
  const auto drive = recording::Drive::open(folder);
  auto setup = daemon::open_drive(folder, {}, {});
  if (!drive || !setup) return false;
  const Rig& rig = drive->description.rig;
  Truth out;
  out.intrinsics = rig.cameras[0].intrinsics;
  out.T_camera_lidar = rig.cameras[0].T_camera_lidar;
  geometry::Trajectory trajectory({.capacity = 200'000});
  if (!drive->description.truth_poses.empty()) {
    const auto poses = recording::read_trajectory(drive->resolve(drive->description.truth_poses));
    if (poses) {
      for (const auto& pose : *poses) trajectory.append({pose.stamp, pose.T_frame_body});
    }
  }
  if (!drive->description.truth_rig.empty()) {
    const auto truth = recording::read_rig(drive->resolve(drive->description.truth_rig));
    if (truth) out.T_camera_lidar = truth->cameras[0].T_camera_lidar;
  }
  motion::Deskewer deskewer(rig.lidars[0].T_vehicle_lidar);
  const Eigen::Matrix3d R_camera_vehicle =
      out.T_camera_lidar.linear() * rig.lidars[0].T_vehicle_lidar.linear().transpose();
  struct ImageFile {
    std::filesystem::path path;
    Stamp stamp;
  };
  std::vector<ImageFile> images;
  std::vector<Sweep> sweeps;
  daemon::LidarIntake intake(setup->lidars[0]);
  const auto match_images = [&] {
    std::erase_if(images, [&](const ImageFile& image) {
      const Sweep* nearest = nullptr;
      for (const Sweep& sweep : sweeps) {
        const auto apart = [&](const Sweep& s) {
          return distance_between(s.stamp + s.span / 2, image.stamp);
        };
        if (nearest == nullptr || apart(sweep) < apart(*nearest)) nearest = &sweep;
      }
      if (nearest == nullptr) return true;
      auto grey = read_grey(image.path, image.stamp);
      if (!grey) return true;
      ImageSweepPair pair{*std::move(grey), *nearest, {}, {}};
      motion::DeskewedSweep deskewed;
      deskewer.deskew(*nearest, trajectory, image.stamp, deskewed);
      if (deskewed.usable()) {
        pair.sweep.x = deskewed.x;
        pair.sweep.y = deskewed.y;
        pair.sweep.z = deskewed.z;
      }
      const auto before = trajectory.at(image.stamp - Duration(50'000'000));
      const auto after = trajectory.at(image.stamp + Duration(50'000'000));
      if (before.usable() && after.usable()) {
        const geometry::Vector6 twist =
            geometry::log(before.T_odom_vehicle.inverse() * after.T_odom_vehicle) / 0.1;
        pair.angular_rate = R_camera_vehicle * twist.head<3>();
        pair.velocity = R_camera_vehicle * twist.tail<3>();
      }
      callback(std::as_const(out), pair);
      return true;
    });
  };
  const auto on_sweep = [&](Sweep& sweep) {
    if (sweep.size() < 1000) return;
    sweeps.push_back(sweep);
    if (sweeps.size() > 3) sweeps.erase(sweeps.begin());
    if (!images.empty() && sweep.stamp > images.front().stamp) match_images();
  };
  recording::DriveEvent event;
  while (setup->source.next(event)) {
    if (const auto* datagram = std::get_if<recording::DatagramEvent>(&event.content)) {
      intake.add_datagram(datagram->datagram, on_sweep);
    } else if (const auto* sweep = std::get_if<recording::SweepEvent>(&event.content)) {
      intake.add_sweep(*sweep->sweep, on_sweep);
    } else if (const auto* image = std::get_if<recording::ImageEvent>(&event.content)) {
      if (image->camera == 0) images.push_back({*image->path, event.stamp});
    }
  }
  intake.finish(on_sweep);
  match_images();
  return true;
}

/// Reads a whole drive; empty if there is none.
inline Drive read_drive(const std::filesystem::path& folder) {
  Drive drive;
  for_each_pair(folder, [&](const Truth& truth, ImageSweepPair& pair) {
    static_cast<Truth&>(drive) = truth;
    drive.pairs.push_back(std::move(pair));
  });
  return drive;
}

}  // namespace infuse::online
