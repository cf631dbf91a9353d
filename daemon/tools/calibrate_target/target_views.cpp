#include "daemon/tools/calibrate_target/target_views.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "daemon/command_line/progress_line.hpp"
#include "daemon/playback/list_images.hpp"
#include "daemon/playback/play_lidar.hpp"
#include "daemon/playback/read_image.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/recording/drive_toml.hpp"
#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/target/board_pose.hpp"
#include "fusion/target/find_boards.hpp"

namespace infuse::daemon {
namespace {

constexpr Duration kMaxTimeGap = std::chrono::milliseconds(500);  // between an image and its sweep

/// An image file and its stamp.
struct StampedImageFile {
  std::filesystem::path path;
  Stamp stamp;
};

/// Finds boards in the images of one drive.
class BoardFinder {
 public:
  BoardFinder(const CameraMount& camera, const recording::CameraFiles& files,
              const target::Board& board, const TargetViewOptions& options, TargetViews& views)
      : camera_(camera),
        files_(files),
        model_(camera.intrinsics),
        board_(board),
        options_(options),
        out_(views) {}

  void process(const StampedImageFile& image, const Sweep& sweep) {
    const auto folder = image.path.parent_path();
    const std::string name = fmt::format("{}/{}/{}", folder.parent_path().filename().string(),
                                         folder.filename().string(), image.path.stem().string());
    const auto grey = read_grey_image(image.path, files_.mosaic);
    if (!grey) return skip(grey.error().message());
    if (grey->width != camera_.intrinsics.width || grey->height != camera_.intrinsics.height) {
      return skip(fmt::format("{}: {} × {} pixels, the rig states {} × {}", name, grey->width,
                              grey->height, camera_.intrinsics.width, camera_.intrinsics.height));
    }
    const auto boards = target::find_boards(*grey, board_, options_.max_boards);
    if (boards.empty()) return skip(name + ": no board in the image");
    for (size_t k = 0; k < boards.size(); ++k) {
      add_board(fmt::format("{} board {}", name, k + 1), boards[k], sweep);
    }
  }

 private:
  void skip(std::string reason) { out_.skipped.push_back(std::move(reason)); }

  void add_board(const std::string& name, const target::Corners& corners, const Sweep& sweep) {
    const auto pose = target::estimate_board_pose(model_, board_, corners, options_.corner_noise);
    if (!pose) return skip(name + ": no board pose fits the corners");
    const Eigen::Vector3d middle = pose->T_camera_board * board_.middle();
    for (size_t i = 0; i < centres_.size(); ++i) {
      const double turned = std::acos(
          std::clamp(std::abs(normals_[i].dot(pose->T_camera_board.linear().col(2))), 0.0, 1.0));
      if ((centres_[i] - middle).norm() < options_.min_motion && turned < options_.min_motion) {
        return;  // an earlier image has this view already
      }
    }
    auto near =
        target::crop_to_board(sweep, camera_.T_camera_lidar.inverse() * pose->T_camera_board,
                              board_, options_.returns.margin);
    if (near.size() < static_cast<size_t>(options_.returns.min_returns)) {
      return skip(fmt::format("{}: only {} returns on the board", name, near.size()));
    }
    centres_.push_back(middle);
    normals_.push_back(pose->T_camera_board.linear().col(2));
    out_.names.push_back(name);
    out_.observations.push_back({pose->T_camera_board, pose->covariance, std::move(near)});
  }

  const CameraMount& camera_;
  const recording::CameraFiles& files_;
  geometry::CameraModel model_;
  target::Board board_;
  const TargetViewOptions& options_;
  TargetViews& out_;
  std::vector<Eigen::Vector3d> centres_, normals_;  // of the boards found so far
};

/// Pairs images with sweeps: an image waits for the sweep after it.
class ImageSweepPairing {
 public:
  ImageSweepPairing(BoardFinder& finder) : finder_(finder) {}

  void add_image(const StampedImageFile& image) { waiting_.push_back(image); }

  void add_sweep(const Sweep& sweep) {
    const Stamp middle = sweep.stamp + sweep.span / 2;
    std::erase_if(waiting_, [&](const StampedImageFile& image) {
      if (image.stamp > middle) return false;
      const bool before = has_last_ && distance_between(image.stamp, last_middle_) <
                                           distance_between(image.stamp, middle);
      const Stamp nearest = before ? last_middle_ : middle;
      if (distance_between(image.stamp, nearest) <= kMaxTimeGap) {
        finder_.process(image, before ? last_ : sweep);
      }
      return true;
    });
    last_ = sweep;
    last_middle_ = middle;
    has_last_ = true;
  }

  void finish() {
    for (const StampedImageFile& image : waiting_) {
      if (has_last_ && distance_between(image.stamp, last_middle_) <= kMaxTimeGap) {
        finder_.process(image, last_);
      }
    }
    waiting_.clear();
  }

 private:
  BoardFinder& finder_;
  std::vector<StampedImageFile> waiting_;
  Sweep last_;
  Stamp last_middle_;
  bool has_last_ = false;
};

void read_drive(SensorSetup& setup, size_t camera, size_t lidar, ImageSweepPairing& pairing) {
  ProgressLine line;
  const auto on_sweep = [&](Sweep& sweep) { pairing.add_sweep(sweep); };
  const auto on_sample = [](const VehicleSample&) {};
  play_lidar(setup, lidar, on_sweep, on_sample, [&](const recording::DriveEvent& event) {
    if (const auto* image = std::get_if<recording::ImageEvent>(&event.content)) {
      if (image->camera == camera) pairing.add_image({*image->path, event.stamp});
      line.show(std::nullopt, fmt::format("image {}", image->sequence));
    }
    return true;
  });
  pairing.finish();
  line.clear();
}

std::optional<Eigen::Isometry3d> true_extrinsics(const recording::Drive& drive,
                                                 const std::string& camera) {
  if (drive.description.truth_rig.empty()) return std::nullopt;
  const auto rig = recording::read_rig(drive.resolve(drive.description.truth_rig));
  const CameraMount* mount = rig ? rig->find_camera(camera) : nullptr;
  return mount == nullptr ? std::nullopt : std::optional(mount->T_camera_lidar);
}

}  // namespace

std::optional<std::string> TargetViewOptions::invalid() const {
  if (auto wrong = returns.invalid()) return wrong;
  if (!(corner_noise > 0)) return "corner_noise must be positive";
  if (max_boards < 1) return "max_boards must be at least 1";
  if (!(min_motion >= 0)) return "min_motion must not be negative";
  return std::nullopt;
}

Result<void> add_target_views(const std::filesystem::path& folder, const std::string& camera,
                              const target::Board& board, const TargetViewOptions& options,
                              TargetViews& views) {
  const auto drive = recording::Drive::open(folder);
  if (!drive) return tl::unexpected(drive.error());
  const Rig& rig = drive->description.rig;
  const auto index = find_camera(rig, camera, folder.string());
  if (!index) return tl::unexpected(index.error());
  auto setup = open_drive(folder, {}, {});
  if (!setup) return tl::unexpected(setup.error());
  const CameraMount& mount = rig.cameras[*index];
  const auto lidar = std::find_if(rig.lidars.begin(), rig.lidars.end(),
                                  [&](const LidarMount& l) { return l.name == mount.lidar; });
  if (lidar == rig.lidars.end())
    return fail("the drive does not have the camera's lidar", folder.string());

  if (views.camera.empty()) {
    views.camera = mount.name;
    views.rig = rig;
    views.T_camera_lidar = mount.T_camera_lidar;
    views.truth = true_extrinsics(*drive, mount.name);
  }
  BoardFinder finder(mount, drive->description.cameras[*index], board, options, views);
  ImageSweepPairing pairing(finder);
  read_drive(*setup, *index, static_cast<size_t>(lidar - rig.lidars.begin()), pairing);
  return {};
}

}  // namespace infuse::daemon
