#include "drivers/import/kitti_layouts.hpp"

#include <algorithm>
#include <set>

#include "drivers/import/kitti_exposures.hpp"
#include "drivers/import/kitti_files.hpp"
#include "drivers/import/kitti_oxts.hpp"
#include "drivers/import/ring_cuts.hpp"
#include "drivers/import/turn_check.hpp"
#include "drivers/recording/rigid_matrix.hpp"

namespace infuse::importers {
namespace {

namespace fs = std::filesystem;

constexpr Duration kSyntheticFramePeriod{100'000'000};
constexpr size_t kMaxFrames = 1'000'000;  // of a recording without stamps

std::string camera_folder(size_t camera) { return "image_" + std::to_string(camera); }

// Assigns index · 0.1 s to every frame that has a sweep or an image.
std::map<size_t, Stamp> synthesize_times(const NumberedFiles& sweeps,
                                         const std::array<NumberedFiles, 4>& images) {
  std::map<size_t, Stamp> times;
  for (const auto& [number, path] : sweeps) times[number] = Stamp();
  for (const NumberedFiles& files : images) {
    for (const auto& [number, path] : files) times[number] = Stamp();
  }
  Stamp stamp;
  for (auto& [number, time] : times) {
    time = stamp;
    stamp += kSyntheticFramePeriod;
  }
  return times;
}

std::vector<StampedFile> stamp_files(const NumberedFiles& files,
                                     const std::map<size_t, Stamp>& times) {
  std::vector<StampedFile> result;
  for (const auto& [number, path] : files)
    result.push_back({{.stamp = times.at(number)}, path, number});
  return result;
}

// A calibration, and the frames that have it.
struct SharedCalibration {
  KittiCalibration calibration;
  std::set<size_t> frames;
};

Result<SharedCalibration> find_most_frequent_calibration(const NumberedFiles& files,
                                                         std::vector<Error>& notes) {
  std::vector<SharedCalibration> groups;
  for (const auto& [number, path] : files) {
    const auto calibration = read_kitti_calibration(path);
    if (!calibration) {
      notes.push_back(calibration.error());
      continue;
    }
    auto group = std::find_if(groups.begin(), groups.end(), [&](const SharedCalibration& g) {
      return g.calibration == *calibration;
    });
    if (group == groups.end()) group = groups.insert(group, {*calibration, {}});
    group->frames.insert(number);
  }
  const auto best = std::max_element(groups.begin(), groups.end(),
                                     [](const SharedCalibration& a, const SharedCalibration& b) {
                                       return a.frames.size() < b.frames.size();
                                     });
  if (best == groups.end()) {
    return notes.empty() ? fail("contains no calibration")
                         : Result<SharedCalibration>(tl::unexpected(notes.front()));
  }
  if (groups.size() > 1) {
    notes.push_back({std::to_string(groups.size()) + " calibrations", "calib/",
                     "only the " + std::to_string(best->frames.size()) +
                         " frames with the most frequent one are imported: a drive has one rig"});
  }
  return std::move(*best);
}

size_t keep_frames(NumberedFiles& files, const std::set<size_t>& frames) {
  return std::erase_if(files, [&](const auto& file) { return !frames.contains(file.first); });
}

Result<fs::path> find_odometry_calibration(const fs::path& folder) {
  if (fs::exists(folder / "calib.txt")) return folder / "calib.txt";
  std::vector<fs::path> found;
  std::error_code failed;
  for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end;
       entry.increment(failed)) {
    const std::string name = entry->path().filename().string();
    if (name.starts_with("calib") && name.ends_with(".txt")) found.push_back(entry->path());
  }
  if (found.size() == 1) return found.front();
  return fail(found.empty() ? "has no calib.txt" : "has several calib*.txt", folder.string());
}

std::optional<fs::path> find_odometry_poses(const fs::path& folder) {
  const fs::path absolute = fs::absolute(folder).lexically_normal();
  const fs::path sequence_folder = absolute.filename().empty() ? absolute.parent_path() : absolute;
  for (const fs::path& path : {folder / "poses.txt", folder / "poses_gt_cam0.txt",
                               sequence_folder.parent_path().parent_path() / "poses" /
                                   (sequence_folder.filename().string() + ".txt")}) {
    if (fs::exists(path)) return path;
  }
  return std::nullopt;
}

// Reads poses of rectified camera 0 relative to its first pose, and converts them to poses of the
// vehicle relative to its first pose.
Result<std::vector<recording::TrajectoryPose>> read_odometry_poses(
    const fs::path& path, const std::vector<std::optional<Stamp>>& times,
    const KittiCalibration& calibration) {
  const auto rows = read_number_lines(path, 12);
  if (!rows) return tl::unexpected(rows.error());
  const Eigen::Isometry3d T_vehicle_camera =
      calibration.T_vehicle_lidar() * calibration.T_rectified_lidar.inverse();
  std::vector<recording::TrajectoryPose> poses;
  for (size_t i = 0; i < rows->size() && i < times.size(); ++i) {
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    matrix.topRows<3>() =
        Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>((*rows)[i].data());
    const auto T_first_camera = recording::to_rigid(matrix);
    if (!T_first_camera) {
      return fail("is not a rigid motion", path.string() + ":" + std::to_string(i + 1));
    }
    if (!times[i]) continue;
    poses.push_back({*times[i], T_vehicle_camera * *T_first_camera * T_vehicle_camera.inverse()});
  }
  return poses;
}

// The stamps are those of the middles of the turns.
void centre_turns(Duration period, std::vector<StampedFile>& sweeps) {
  for (StampedFile& sweep : sweeps) {
    const Stamp middle = sweep.times.stamp;
    sweep.times = {.stamp = middle - period / 2, .end = middle + period / 2};
  }
}

using Turns = std::vector<std::optional<TurnTimes>>;

std::vector<StampedFile> read_raw_sweeps(const fs::path& folder, const Turns& turns,
                                         std::vector<Error>& notes) {
  std::vector<std::optional<Stamp>> starts;
  for (const auto& turn : turns) starts.push_back(turn ? std::optional(turn->start) : std::nullopt);
  auto sweeps = assign_times(list_files(folder / "data", ".bin"), starts, notes);
  for (StampedFile& sweep : sweeps) sweep.times.end = turns[sweep.number]->end;
  return sweeps;
}

Result<void> read_raw_images(const fs::path& folder, size_t camera, const Turns& turns,
                             KittiRecording& recording) {
  const auto times = read_kitti_times(folder / "timestamps.txt");
  if (!times) return tl::unexpected(times.error());
  std::vector<StampedFile>& images = recording.images[camera];
  images = assign_times(list_images(folder / "data"), *times, recording.notes);
  if (images.empty()) return {};
  const auto exposures = find_exposures(folder.string(), turns, images);
  if (!exposures) return tl::unexpected(exposures.error());
  recording.stamp_delay[camera] = exposures->delay;
  recording.stamp_delay_sigma[camera] = exposures->sigma;
  recording.notes.push_back(exposures->note);
  return {};
}

// KITTI's lidar turns clockwise and its sweeps are cut at the rear, whatever the readme says.
void find_turn(const std::string& where, const std::vector<recording::TrajectoryPose>& path,
               KittiRecording& recording) {
  recording::Turn turn;
  turn.ring_cuts_deg = find_ring_cuts(recording.sweeps, turn.cut_deg);
  const TurnCheck check =
      check_turn(turn, recording.sweeps, path, recording.calibration.T_vehicle_lidar());
  const bool by_ring = !turn.ring_cuts_deg.empty();
  const std::string rule = std::string("a turn clockwise, cut at the rear") +
                           (by_ring ? ", each ring at an azimuth of its own" : "");
  switch (check.verdict) {
    case TurnCheck::Verdict::kBlurs:
      recording.notes.push_back(
          {"the times that follow from " + rule + " blur the sweeps (" + check.reason + ")", where,
           "the returns have no times, so that the sweeps cannot be deskewed"});
      return;
    case TurnCheck::Verdict::kConfirmed:
      recording.notes.push_back({"each return's time follows from its azimuth: " + rule +
                                     ", as the sweeps confirm (" + check.reason + ")",
                                 where,
                                 {}});
      break;
    case TurnCheck::Verdict::kUnknown:
      recording.notes.push_back({"each return's time follows from its azimuth: " + rule +
                                     ", as in all of KITTI; not checked: " + check.reason,
                                 where,
                                 {}});
  }
  recording.turn = turn;
}

}  // namespace

Result<KittiRecording> read_kitti_object(const fs::path& folder) {
  KittiRecording recording;
  auto shared =
      find_most_frequent_calibration(list_files(folder / "calib", ".txt"), recording.notes);
  if (!shared) return tl::unexpected(shared.error());
  recording.calibration = shared->calibration;

  NumberedFiles sweeps = list_files(folder / "velodyne", ".bin");
  size_t left_out = keep_frames(sweeps, shared->frames);
  std::array<NumberedFiles, 4> images;
  for (size_t camera = 0; camera < images.size(); ++camera) {
    images[camera] = list_images(folder / camera_folder(camera));
    left_out += keep_frames(images[camera], shared->frames);
  }
  if (left_out > 0) {
    recording.notes.push_back(
        {std::to_string(left_out) + " files of frames with another calibration are skipped",
         folder.string(),
         {}});
  }
  const auto times = synthesize_times(sweeps, images);
  recording.sweeps = stamp_files(sweeps, times);
  for (size_t camera = 0; camera < images.size(); ++camera) {
    recording.images[camera] = stamp_files(images[camera], times);
  }
  return recording;
}

Result<KittiRecording> read_kitti_odometry(const fs::path& folder) {
  KittiRecording recording;
  const auto calibration_file = find_odometry_calibration(folder);
  if (!calibration_file) return tl::unexpected(calibration_file.error());
  const auto calibration = read_kitti_calibration(*calibration_file);
  if (!calibration) return tl::unexpected(calibration.error());
  recording.calibration = *calibration;
  const NumberedFiles sweeps = list_files(folder / "velodyne", ".bin");
  Result<std::vector<std::optional<Stamp>>> times;
  recording.times_trusted = fs::exists(folder / "times.txt");
  if (recording.times_trusted) {
    times = read_kitti_times(folder / "times.txt");
    if (!times) return tl::unexpected(times.error());
  } else {
    const size_t frames = sweeps.empty() ? 0 : std::min(sweeps.rbegin()->first + 1, kMaxFrames);
    for (size_t i = 0; i < frames; ++i) times->push_back(Stamp() + kSyntheticFramePeriod * i);
  }

  recording.sweeps = assign_times(sweeps, *times, recording.notes);
  recording.deskewed = true;
  if (recording.times_trusted) centre_turns(usual_period(*times), recording.sweeps);
  recording.notes.push_back({"the sweeps are already deskewed, to the stamp of their images",
                             (folder / "velodyne").string(), "they are used as they are"});
  for (size_t camera = 0; camera < recording.images.size(); ++camera) {
    recording.images[camera] =
        assign_times(list_images(folder / camera_folder(camera)), *times, recording.notes);
  }
  if (const auto path = find_odometry_poses(folder)) {
    auto poses = read_odometry_poses(*path, *times, *calibration);
    if (!poses) return tl::unexpected(poses.error());
    recording.poses = std::move(*poses);
  }
  return recording;
}

Result<KittiRecording> read_kitti_raw(const fs::path& folder) {
  KittiRecording recording;
  const fs::path parent_folder = fs::absolute(folder).lexically_normal() / "..";
  const auto calibration = read_kitti_raw_calibration(
      fs::exists(folder / "calib_cam_to_cam.txt") ? folder : parent_folder);
  if (!calibration) return tl::unexpected(calibration.error());
  recording.calibration = *calibration;
  recording.times_trusted = true;

  const fs::path sweeps_folder = folder / "velodyne_points";
  const auto turns = read_kitti_turn_times(sweeps_folder, recording.notes);
  if (!turns) return tl::unexpected(turns.error());
  recording.sweeps = read_raw_sweeps(sweeps_folder, *turns, recording.notes);
  for (size_t camera = 0; camera < recording.images.size(); ++camera) {
    const fs::path images_folder = folder / ("image_0" + std::to_string(camera));
    if (!fs::exists(images_folder)) continue;
    if (auto read = read_raw_images(images_folder, camera, *turns, recording); !read)
      return tl::unexpected(read.error());
  }
  KittiOxts oxts;
  if (fs::exists(folder / "oxts")) {
    const Eigen::Isometry3d T_lidar_imu =
        recording.calibration.T_lidar_imu.value_or(Eigen::Isometry3d::Identity());
    auto read = read_kitti_oxts(folder / "oxts",
                                (recording.calibration.T_vehicle_lidar() * T_lidar_imu).inverse(),
                                *turns, recording.notes);
    if (!read) return tl::unexpected(read.error());
    oxts = std::move(*read);
  }
  find_turn(sweeps_folder.string(), oxts.path, recording);
  recording.poses = std::move(oxts.poses);
  recording.speed = std::move(oxts.speed);
  recording.imu = std::move(oxts.imu);
  recording.gnss = std::move(oxts.gnss);
  return recording;
}

}  // namespace infuse::importers
