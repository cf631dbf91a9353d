#include "tests/bench/streetmap_drive.hpp"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "daemon/pipeline/lidar_intake.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "daemon/streetmap/street_plan_from_osm.hpp"
#include "drivers/camera/image_decoder.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/recording/mapped_file.hpp"
#include "drivers/recording/times_csv.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "fusion/geometry/trajectory.hpp"
#include "fusion/motion/deskew.hpp"
#include "fusion/streetmap/rasterise.hpp"
#include "tests/bench/rendered_drive.hpp"

namespace infuse::streetmap::bench {
namespace {

const std::filesystem::path kDrivesFolder = bench_drives_folder();
constexpr double kMinViewInterval = 0.4;  // s between views, at least
constexpr double kMaxImageOffset = 0.12;  // s from a sweep's middle

PlanarPose to_planar_pose(const Eigen::Isometry3d& T) {
  return {T.translation().x(), T.translation().y(), std::atan2(T(1, 0), T(0, 0))};
}

geometry::Trajectory read_truth(const std::filesystem::path& folder) {
  const auto poses = recording::read_trajectory(folder / "truth/poses.tum");
  if (!poses) return geometry::Trajectory();
  geometry::Trajectory trajectory({.capacity = poses->size() + 2});
  for (const auto& pose : *poses) trajectory.append({pose.stamp, pose.T_frame_body});
  return trajectory;
}

bool decode(const std::filesystem::path& path, CameraFrame& image) {
  const auto file = recording::MappedFile::open(path);
  if (!file) return false;
  const auto bytes = file->bytes();
  return camera::decode_image({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}, {},
                              image)
      .has_value();
}

/// Collects sweeps, each with the image nearest in time, and returns views.
class ViewCollector {
 public:
  ViewCollector(const std::filesystem::path& folder, const Rig& rig)
      : rig_(rig),
        truth_(read_truth(folder)),
        camera_(rig.cameras[0].intrinsics),
        deskewer_(rig.lidars[0].T_vehicle_lidar) {
    if (const auto images = recording::index_images(folder / "front")) images_ = images->entries;
  }

  void add_sweep(const Sweep& sweep) {
    constexpr size_t kMinReturns = 1000;
    if (sweep.size() < kMinReturns || images_.empty()) return;
    const Stamp middle = sweep.stamp + sweep.span / 2;
    const auto time_offset = [&](size_t i) { return distance_between(images_[i].stamp, middle); };
    while (next_ + 1 < images_.size() && time_offset(next_ + 1) < time_offset(next_)) ++next_;
    const bool has_image = time_offset(next_) < from_seconds(kMaxImageOffset) &&
                           decode(images_[next_].path, image_) &&
                           extract_features(image_, 2, features_);
    const Stamp reference = has_image ? images_[next_].stamp : middle;
    deskewer_.deskew(sweep, truth_, reference, deskewed_);
    if (!deskewed_.usable()) return;
    const ImageView view{features_, camera_, rig_.cameras[0].T_camera_lidar};
    const PlanarPose pose = to_planar_pose(truth_.at(reference).T_odom_vehicle);
    grid_.add({sweep, deskewed_.x, deskewed_.y, deskewed_.z, rig_.lidars[0].T_vehicle_lidar},
              has_image ? &view : nullptr, pose);
    const double now = to_seconds(reference - truth_[0].stamp);
    if (!views_.empty() && now - views_.back().seconds < kMinViewInterval) return;
    views_.push_back({now, pose, {}});
    grid_.draw_samples(pose, views_.back().samples);
  }

  std::vector<View> views() { return std::move(views_); }

 private:
  Rig rig_;
  geometry::Trajectory truth_;
  std::vector<recording::SequenceEntry> images_;
  size_t next_ = 0;
  geometry::CameraModel camera_;
  motion::Deskewer deskewer_;
  LocalGrid grid_;
  CameraFrame image_;
  ImageFeatures features_;
  motion::DeskewedSweep deskewed_;
  std::vector<View> views_;
};

void write_cache(const std::filesystem::path& path, const std::vector<View>& views) {
  std::ofstream file(path, std::ios::binary);
  const auto put = [&](const void* data, size_t bytes) {
    file.write(static_cast<const char*>(data), static_cast<std::streamsize>(bytes));
  };
  for (const View& view : views) {
    const uint64_t shape[2] = {view.samples.size(),
                               static_cast<uint64_t>(view.samples.features.cols())};
    put(&view.seconds, sizeof view.seconds);
    put(&view.truth, sizeof view.truth);
    put(shape, sizeof shape);
    put(view.samples.x.data(), shape[0] * sizeof(float));
    put(view.samples.y.data(), shape[0] * sizeof(float));
    put(view.samples.features.data(), shape[0] * shape[1] * sizeof(double));
  }
}

std::vector<View> read_cache(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const auto get = [&](void* data, size_t bytes) {
    return static_cast<bool>(
        file.read(static_cast<char*>(data), static_cast<std::streamsize>(bytes)));
  };
  std::vector<View> views;
  View view;
  uint64_t shape[2];
  while (get(&view.seconds, sizeof view.seconds) && get(&view.truth, sizeof view.truth) &&
         get(shape, sizeof shape)) {
    view.samples.x.resize(shape[0]);
    view.samples.y.resize(shape[0]);
    view.samples.features.resize(static_cast<Eigen::Index>(shape[0]),
                                 static_cast<Eigen::Index>(shape[1]));
    if (!get(view.samples.x.data(), shape[0] * sizeof(float)) ||
        !get(view.samples.y.data(), shape[0] * sizeof(float)) ||
        !get(view.samples.features.data(), shape[0] * shape[1] * sizeof(double))) {
      break;
    }
    views.push_back(view);
  }
  return views;
}

}  // namespace

geometry::Trajectory read_truth(const std::string& drive) {
  return read_truth(kDrivesFolder / drive);
}

bool is_rendered(const std::string& drive) {
  return std::filesystem::exists(kDrivesFolder / drive / "drive.toml");
}

bool render(const std::string& drive) {
  std::string scenario = drive == "street" ? "online_2hz" : drive, more;
  if (drive.starts_with("kitti_")) {
    const char* data = std::getenv("INFUSE_REAL_DATA");
    if (data == nullptr) {
      std::fprintf(stderr, "%s: INFUSE_REAL_DATA is not set\n", drive.c_str());
      return false;
    }
    const std::string recorded =
        (std::filesystem::path(data) / "street" / drive.substr(6)).string();
    const std::string route = (kDrivesFolder / (drive + ".txt")).string();
    std::filesystem::create_directories(kDrivesFolder);
    if (std::system(("bunzip2 -c " + recorded + ".txt.bz2 > " + route).c_str()) != 0) return false;
    scenario = "kitti_route";
    more = " --map " + recorded + ".osm.bz2 --trajectory " + route;
  }
  if (drive.starts_with("bare_")) {
    scenario = "bare";
    more = " --seed " + drive.substr(5);
  }
  return std::filesystem::exists(rendered_drive(scenario, drive, more) / "drive.toml");
}

std::vector<View> read_views(const std::string& drive) {
  const std::filesystem::path cache = kDrivesFolder / (drive + ".views");
  const std::filesystem::path folder = kDrivesFolder / drive;
  std::error_code none;  // of a drive that was rendered later
  if (std::filesystem::last_write_time(cache, none) >
      std::filesystem::last_write_time(folder / "drive.toml", none)) {
    return read_cache(cache);
  }
  auto setup = daemon::open_drive(folder, {}, {});
  const auto opened = recording::Drive::open(folder);
  if (!setup || !opened) return {};
  ViewCollector collector(folder, opened->description.rig);
  const auto on_sweep = [&](const Sweep& sweep) { collector.add_sweep(sweep); };
  daemon::LidarIntake intake(setup->lidars[0]);
  recording::DriveEvent event;
  while (setup->source.next(event)) {
    const auto* datagram = std::get_if<recording::DatagramEvent>(&event.content);
    if (datagram != nullptr && datagram->lidar == 0)
      intake.add_datagram(datagram->datagram, on_sweep);
  }
  intake.finish(on_sweep);
  std::vector<View> views = collector.views();
  write_cache(cache, views);
  return views;
}

std::vector<PosedImage> read_posed_images(const std::string& drive, int count, CameraMount& mount) {
  const std::filesystem::path folder = kDrivesFolder / drive;
  const auto opened = recording::Drive::open(folder);
  const auto images = recording::index_images(folder / "front");
  const geometry::Trajectory truth = read_truth(folder);
  std::vector<PosedImage> posed_images;
  if (!opened || !images || truth.empty()) return posed_images;
  mount = opened->description.rig.cameras[0];
  // The mount is seen from the lidar; the vehicle's is wanted here.
  mount.T_camera_lidar =
      mount.T_camera_lidar * opened->description.rig.lidars[0].T_vehicle_lidar.inverse();
  for (int i = 0; i < count; ++i) {
    const size_t at = (static_cast<size_t>(i) * 2 + 1) * images->entries.size() /
                      (2 * static_cast<size_t>(count));
    const geometry::PoseAt pose = truth.at(images->entries[at].stamp);
    PosedImage posed_image;
    if (!pose.usable() || !decode(images->entries[at].path, posed_image.image)) continue;
    posed_image.truth = to_planar_pose(pose.T_odom_vehicle);
    posed_images.push_back(std::move(posed_image));
  }
  return posed_images;
}

DriveMap make_map(const std::string& drive, const std::optional<StreetPlan>& plan) {
  DriveMap made;
  if (plan) {
    made.plan = *plan;
  } else if (const auto opened = recording::Drive::open(kDrivesFolder / drive)) {
    const auto map = osm::read_openstreetmap(kDrivesFolder / drive / opened->description.map);
    if (map) made.plan = daemon::build_street_plan(*map).plan;
  }
  if (auto bytes = rasterise(made.plan, {}, drive)) made.bytes = std::move(*bytes);
  if (const auto map = SegmentMap::open(made.bytes, drive)) made.map = *map;
  return made;
}

}  // namespace infuse::streetmap::bench
