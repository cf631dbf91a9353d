#include "tests/bench/streetmap_drive.hpp"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "daemon/pipeline/drive_setup.hpp"
#include "daemon/pipeline/lidar_intake.hpp"
#include "daemon/streetmap/plan_streets.hpp"
#include "drivers/camera/picture.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/recording/mapped_file.hpp"
#include "drivers/recording/times_csv.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "fusion/geometry/trajectory.hpp"
#include "fusion/motion/compensation.hpp"
#include "fusion/streetmap/rasterise.hpp"
#include "tests/bench/rendered_drive.hpp"

namespace infuse::streetmap::bench {
namespace {

const std::filesystem::path kDrives = bench_drives();
constexpr double kInterval = 0.4;      // s between views, at least
constexpr double kNearPicture = 0.12;  // s from a sweep's middle

PlanarPose planar(const Eigen::Isometry3d& T) {
  return {T.translation().x(), T.translation().y(), std::atan2(T(1, 0), T(0, 0))};
}

geometry::Trajectory read_truth(const std::filesystem::path& folder) {
  const auto poses = recording::read_trajectory(folder / "truth/poses.tum");
  if (!poses) return geometry::Trajectory();
  geometry::Trajectory trajectory({.capacity = poses->size() + 2});
  for (const auto& pose : *poses) trajectory.append({pose.stamp, pose.T_map_body});
  return trajectory;
}

bool decode(const std::filesystem::path& path, CameraFrame& picture) {
  const auto file = recording::MappedFile::open(path);
  if (!file) return false;
  const auto bytes = file->bytes();
  return camera::decode_picture({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}, {},
                                picture)
      .has_value();
}

/// Collects sweeps, each with the picture nearest to it, and gives out views.
class Collector {
 public:
  Collector(const std::filesystem::path& folder, const Rig& rig)
      : rig_(rig),
        truth_(read_truth(folder)),
        camera_(rig.cameras[0].intrinsics),
        compensator_(rig.lidars[0].T_vehicle_lidar) {
    if (const auto images = recording::index_images(folder / "front")) images_ = images->entries;
  }

  void take(const Sweep& sweep) {
    constexpr size_t kFewest = 1000;
    if (sweep.size() < kFewest || images_.empty()) return;
    const Stamp middle = sweep.stamp + sweep.span / 2;
    const auto off = [&](size_t i) { return distance_between(images_[i].stamp, middle); };
    while (next_ + 1 < images_.size() && off(next_ + 1) < off(next_)) ++next_;
    const bool seen = off(next_) < from_seconds(kNearPicture) &&
                      decode(images_[next_].path, picture_) &&
                      extract_features(picture_, 2, features_);
    const Stamp reference = seen ? images_[next_].stamp : middle;
    compensator_.compensate(sweep, truth_, reference, straight_);
    if (!straight_.usable()) return;
    const PictureView view{features_, camera_, rig_.cameras[0].T_camera_lidar};
    const PlanarPose pose = planar(truth_.at(reference).T_map_vehicle);
    grid_.add({sweep, straight_.x, straight_.y, straight_.z, rig_.lidars[0].T_vehicle_lidar},
              seen ? &view : nullptr, pose);
    const double now = to_seconds(reference - truth_[0].stamp);
    if (!views_.empty() && now - views_.back().seconds < kInterval) return;
    views_.push_back({now, pose, {}});
    grid_.samples(pose, views_.back().samples);
  }

  std::vector<View> views() { return std::move(views_); }

 private:
  Rig rig_;
  geometry::Trajectory truth_;
  std::vector<recording::SequenceEntry> images_;
  size_t next_ = 0;
  geometry::CameraModel camera_;
  motion::MotionCompensator compensator_;
  LocalGrid grid_;
  CameraFrame picture_;
  PictureFeatures features_;
  motion::StraightSweep straight_;
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

bool render(const std::string& drive) {
  if (std::filesystem::exists(kDrives / drive / "drive.toml")) return true;
  std::string scenario = drive == "street" ? "online_2hz" : drive, more;
  if (drive.starts_with("kitti_")) {
    const char* data = std::getenv("INFUSE_REAL_DATA");
    if (data == nullptr) {
      std::fprintf(stderr, "%s: INFUSE_REAL_DATA is not set\n", drive.c_str());
      return false;
    }
    const std::string recorded =
        (std::filesystem::path(data) / "street" / drive.substr(6)).string();
    const std::string route = (kDrives / (drive + ".txt")).string();
    std::filesystem::create_directories(kDrives);
    if (std::system(("bunzip2 -c " + recorded + ".txt.bz2 > " + route).c_str()) != 0) return false;
    scenario = "kitti_route";
    more = " --map " + recorded + ".osm.bz2 --trajectory " + route;
  }
  return std::filesystem::exists(rendered_drive(scenario, drive, more) / "drive.toml");
}

std::vector<View> read_views(const std::string& drive) {
  const std::filesystem::path cache = kDrives / (drive + ".views");
  if (std::filesystem::exists(cache)) return read_cache(cache);
  const std::filesystem::path folder = kDrives / drive;
  auto setup = daemon::open_drive(folder, {}, std::nullopt);
  const auto opened = recording::Drive::open(folder);
  if (!setup || !opened) return {};
  Collector collector(folder, opened->description.rig);
  const auto on_sweep = [&](const Sweep& sweep) { collector.take(sweep); };
  daemon::LidarIntake intake(setup->lidars[0]);
  recording::DriveEvent event;
  while (setup->source.next(event)) {
    const auto* datagram = std::get_if<recording::DatagramEvent>(&event.content);
    if (datagram != nullptr && datagram->lidar == 0) intake.take(datagram->datagram, on_sweep);
  }
  intake.finish(on_sweep);
  std::vector<View> views = collector.views();
  write_cache(cache, views);
  return views;
}

std::vector<Shot> read_shots(const std::string& drive, int count, CameraMount& mount) {
  const std::filesystem::path folder = kDrives / drive;
  const auto opened = recording::Drive::open(folder);
  const auto images = recording::index_images(folder / "front");
  const geometry::Trajectory truth = read_truth(folder);
  std::vector<Shot> shots;
  if (!opened || !images || truth.empty()) return shots;
  mount = opened->description.rig.cameras[0];
  // The mount is seen from the lidar; the vehicle's is wanted here.
  mount.T_camera_lidar =
      mount.T_camera_lidar * opened->description.rig.lidars[0].T_vehicle_lidar.inverse();
  for (int i = 0; i < count; ++i) {
    const size_t at = (static_cast<size_t>(i) * 2 + 1) * images->entries.size() /
                      (2 * static_cast<size_t>(count));
    const geometry::PoseAt pose = truth.at(images->entries[at].stamp);
    Shot shot;
    if (!pose.usable() || !decode(images->entries[at].path, shot.picture)) continue;
    shot.truth = planar(pose.T_map_vehicle);
    shots.push_back(std::move(shot));
  }
  return shots;
}

DriveMap make_map(const std::string& drive, const std::optional<StreetPlan>& plan) {
  DriveMap made;
  if (plan) {
    made.plan = *plan;
  } else if (const auto opened = recording::Drive::open(kDrives / drive)) {
    const auto map = recording::read_openstreetmap(kDrives / drive / opened->description.map);
    if (map) made.plan = daemon::plan_streets(*map).plan;
  }
  if (auto bytes = rasterise(made.plan, {}, drive)) made.bytes = std::move(*bytes);
  if (const auto map = SegmentMap::open(made.bytes, drive)) made.map = *map;
  return made;
}

}  // namespace infuse::streetmap::bench
