#include "drivers/import/ford_import.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/import/bag_sinks.hpp"
#include "drivers/import/ford_files.hpp"
#include "drivers/import/ford_frames.hpp"
#include "drivers/import/image_size.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/recording/mapped_file.hpp"
#include "drivers/recording/speed_csv.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::importers {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxStampsBytes = size_t{64} << 20;
constexpr size_t kMaxImageFile = size_t{256} << 20;
constexpr size_t kMaxFordFiles = 1'000'000;

/// Files of a folder with one of the extensions (in lower case), by name; empty without the folder.
std::vector<fs::path> list_ford_files(const fs::path& folder,
                                      const std::vector<std::string>& extensions) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end;
       !error && entry != end && files.size() < kMaxFordFiles; entry.increment(error)) {
    std::string extension = entry->path().extension().string();
    std::ranges::transform(extension, extension.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (entry->is_regular_file(error) &&
        (extensions.empty() || std::ranges::find(extensions, extension) != extensions.end()))
      files.push_back(entry->path());
  }
  std::ranges::sort(files);
  return files;
}

/// The number that ends a file's name; nothing if none does.
std::optional<size_t> number_of(const fs::path& file) {
  const std::string stem = file.stem().string();
  size_t begin = stem.size();
  while (begin > 0 && std::isdigit(static_cast<unsigned char>(stem[begin - 1])) != 0) --begin;
  if (begin == stem.size() || stem.size() - begin > 9) return std::nullopt;
  return static_cast<size_t>(std::stoul(stem.substr(begin)));
}

Result<std::map<std::string, MatArray>> read_mat_file(const fs::path& path,
                                                      const std::set<std::string>& wanted) {
  const auto file = recording::MappedFile::open(path);
  if (!file) return tl::unexpected(file.error());
  return read_mat({reinterpret_cast<const uint8_t*>(file->bytes().data()), file->bytes().size()},
                  path.string(), wanted);
}

/// Adds what a trial has to the drive of its log.
class FordImport {
 public:
  FordImport(fs::path folder, fs::path drive)
      : folder_(std::move(folder)), drive_(std::move(drive)) {}

  Result<FordImportSummary> run() {
    if (auto done = import_log(); !done) return tl::unexpected(done.error());
    add_lidar();
    if (auto done = add_cameras(); !done) return tl::unexpected(done.error());
    if (auto done = add_poses(); !done) return tl::unexpected(done.error());
    if (auto done = add_speeds(); !done) return tl::unexpected(done.error());
    if (auto done = recording::write_drive_toml(drive_, description_); !done)
      return tl::unexpected(done.error());
    return std::move(summary_);
  }

 private:
  void note(const std::string& what, const fs::path& where, const std::string& hint = "") {
    summary_.notes.push_back({what, where.string(), hint});
  }

  Result<void> import_log() {
    std::vector<fs::path> logs = list_ford_files(folder_ / "LCM", {});
    if (logs.empty()) {
      return fail("has no log in LCM", folder_.string(),
                  "captures of its own (VELODYNE) are imported with infuse import folder");
    }
    auto imported = import_lcm(logs, drive_);
    if (!imported) return tl::unexpected(imported.error());
    summary_.packets = imported->packets;
    summary_.channels = std::move(imported->channels);
    std::erase_if(imported->notes, [](const Error& each) {
      return each.what.find("its mounting is unknown") != std::string::npos;
    });
    summary_.notes = std::move(imported->notes);
    auto opened = recording::Drive::open(drive_);
    if (!opened) return tl::unexpected(opened.error());
    description_ = std::move(opened->description);
    description_.name = "Ford Campus data set, " + folder_.filename().string();
    return {};
  }

  void add_lidar() {
    LidarMount& lidar = description_.rig.lidars.front();
    if (description_.rig.lidars.size() > 1) {
      note("several channels have packets: the mounting is that of " + lidar.name, folder_,
           "correct T_vehicle_lidar in drive.toml");
    }
    if (!lidar.model.empty() && lidar.model.find("64") == std::string::npos)
      note("the lidar is a " + lidar.model + ", that of the data set an HDL-64E", folder_);
    lidar.T_vehicle_lidar = ford_T_vehicle_lidar();
    note("the rear axle is taken to be 0.4 m above the ground: the data set does not state it",
         folder_, "correct T_vehicle_lidar in drive.toml");
    note("the beams are those of a typical unit: the data set's are not in its description",
         folder_, "set calibration of the lidar in drive.toml");
  }

  Result<void> add_cameras() {
    std::vector<fs::path> folders;
    std::error_code error;
    for (fs::directory_iterator entry(folder_ / "IMAGES", error), end; !error && entry != end;
         entry.increment(error)) {
      if (entry->is_directory(error) && entry->path().filename() != "FULL")
        folders.push_back(entry->path());
    }
    std::ranges::sort(folders);
    if (folders.empty()) {
      note("no images are taken: there are no folders in IMAGES", folder_);
      return {};
    }
    const auto text = text::read_text(folder_ / "Timestamp.log", kMaxStampsBytes);
    if (!text) {
      note("no images are taken: their stamps cannot be read", folder_ / "Timestamp.log");
      return {};
    }
    const std::vector<Stamp> stamps =
        parse_ford_stamps(*text, (folder_ / "Timestamp.log").string(), summary_.notes);
    const fs::path param = folder_ / "PARAM.mat";
    const auto variables = read_mat_file(param, {"K", "R", "t"});
    const auto cameras = variables ? read_ford_cameras(*variables, param.string())
                                   : tl::unexpected(variables.error());
    if (!cameras) {
      note("no images are taken: " + cameras.error().what, param,
           "no other file states the poses of the cameras");
      return {};
    }
    if (cameras->size() != folders.size()) {
      note("no images are taken: there are " + std::to_string(folders.size()) + " folders and " +
               std::to_string(cameras->size()) + " cameras in PARAM.mat",
           folder_ / "IMAGES");
      return {};
    }
    for (size_t k = 0; k < folders.size(); ++k) {
      if (auto done = add_camera(folders[k], (*cameras)[k], stamps); !done) return done;
    }
    return {};
  }

  /// Stamps of the files: in their order if there are as many, else by the number in their names.
  std::optional<std::vector<Stamp>> stamps_of(const std::vector<fs::path>& files,
                                              const std::vector<Stamp>& stamps) {
    if (files.size() == stamps.size()) return stamps;
    std::vector<size_t> numbers;
    for (const fs::path& file : files) {
      const auto number = number_of(file);
      if (!number) return std::nullopt;
      numbers.push_back(*number);
    }
    const size_t base = std::ranges::min(numbers) == 0 ? 0 : 1;
    if (std::ranges::max(numbers) - base >= stamps.size()) return std::nullopt;
    std::vector<Stamp> chosen;
    for (const size_t number : numbers) chosen.push_back(stamps[number - base]);
    note("the stamps follow from the numbers in the names, from " + std::to_string(base) +
             ": there are " + std::to_string(files.size()) + " images and " +
             std::to_string(stamps.size()) + " stamps",
         files.front().parent_path());
    return chosen;
  }

  Result<void> add_camera(const fs::path& folder, const FordCamera& camera,
                          const std::vector<Stamp>& all_stamps) {
    const auto files = list_ford_files(folder, {".ppm", ".pgm", ".png", ".jpg", ".jpeg"});
    if (files.empty()) {
      note("has no images", folder);
      return {};
    }
    const auto stamps = stamps_of(files, all_stamps);
    if (!stamps) {
      note("is not taken: which stamp belongs to which image is not clear", folder);
      return {};
    }
    CameraMount mount{.name = folder.filename().string(),
                      .lidar = description_.rig.lidars.front().name};
    mount.intrinsics = {.fx = camera.fx, .fy = camera.fy, .cx = camera.cx, .cy = camera.cy};
    mount.T_camera_lidar = camera.T_camera_velodyne * ford_T_velodyne_lidar();
    std::optional<ImageSink> sink;
    for (size_t k = 0; k < files.size(); ++k) {
      const auto bytes = text::read_text(files[k], kMaxImageFile);
      if (!bytes) return tl::unexpected(bytes.error());
      const auto pnm = read_pnm_header(*bytes);
      const auto size = pnm ? ImageSize{pnm->width, pnm->height}
                            : read_image_size(files[k]).value_or(ImageSize{});
      if (size.width == 0) {
        note("is not a PPM, PNG or JPEG image", files[k], "this image is skipped");
        continue;
      }
      if (!sink) {
        mount.intrinsics.width = size.width;
        mount.intrinsics.height = size.height;
        auto created = ImageSink::create(drive_ / mount.name, mount.intrinsics);
        if (!created) return tl::unexpected(created.error());
        sink = std::move(*created);
      }
      const std::span data(reinterpret_cast<const uint8_t*>(bytes->data()), bytes->size());
      if (auto done = pnm ? add_pnm(*sink, *pnm, data, (*stamps)[k])
                          : add_file(*sink, files[k], data, (*stamps)[k]);
          !done)
        return done;
    }
    if (!sink) return {};
    if (auto done = sink->finish(); !done) return done;
    sink->skipped.append_notes(mount.name, summary_.notes);
    summary_.images += sink->images();
    ++summary_.cameras;
    description_.rig.cameras.push_back(mount);
    description_.cameras.emplace_back().images = mount.name;
    return {};
  }

  static Result<void> add_pnm(ImageSink& sink, const PnmHeader& header,
                              std::span<const uint8_t> data, Stamp stamp) {
    ros::Image image;
    image.width = static_cast<uint32_t>(header.width);
    image.height = static_cast<uint32_t>(header.height);
    image.encoding = header.colour ? "rgb8" : "mono8";
    image.step = image.width * (header.colour ? 3U : 1U);
    image.data = data.subspan(header.pixels);
    return sink.add(image, stamp);
  }

  static Result<void> add_file(ImageSink& sink, const fs::path& file, std::span<const uint8_t> data,
                               Stamp stamp) {
    ros::CompressedImage image;
    image.format = file.extension() == ".png" ? "png" : "jpeg";
    image.data = data;
    return sink.add(image, stamp);
  }

  /// Poses of the scans, as truth: the vehicle on a map whose axes are those of the local frame.
  Result<void> add_poses() {
    const auto files = list_ford_files(folder_ / "SCANS", {".mat"});
    std::vector<FordPose> poses;
    size_t without = 0;
    std::string reason;
    for (const fs::path& file : files) {
      const auto variables = read_mat_file(file, {"timestamp_laser", "X_wv"});
      const auto pose =
          variables ? read_ford_scan(*variables, file.string()) : tl::unexpected(variables.error());
      if (!pose) {
        if (without++ == 0) reason = pose.error().message();
        continue;
      }
      poses.push_back(*pose);
    }
    if (without > 0) {
      note("no pose is taken of " + std::to_string(without) + " scans; the first: " + reason,
           folder_ / "SCANS");
    }
    std::ranges::stable_sort(poses, {}, &FordPose::stamp);
    const auto same_time = [](const FordPose& a, const FordPose& b) { return a.stamp == b.stamp; };
    poses.erase(std::unique(poses.begin(), poses.end(), same_time), poses.end());
    if (poses.empty()) return {};
    std::vector<recording::TrajectoryPose> truth;
    for (const FordPose& pose : poses)
      truth.push_back({pose.stamp, pose.T_local_body * ford_T_body_vehicle()});
    // The thesis calls the local frame east-north-up; by its table the body's z points down.
    double up = 0;
    for (const auto& pose : truth) up += pose.T_frame_body.linear()(2, 2);
    if (up < 0) {
      Eigen::Isometry3d turned = Eigen::Isometry3d::Identity();
      turned.linear() = Eigen::Vector3d(1, -1, -1).asDiagonal();
      for (auto& pose : truth) pose.T_frame_body = turned * pose.T_frame_body;
      note("the poses' z axis points down: the truth is turned about x", folder_ / "SCANS");
    }
    std::error_code failed;
    fs::create_directories(drive_ / "truth", failed);
    description_.truth_poses = "truth/poses.tum";
    summary_.poses = truth.size();
    return text::write_text(drive_ / description_.truth_poses, recording::format_tum(truth));
  }

  /// Speed and yaw rate by the inertial system.
  Result<void> add_speeds() {
    fs::path file;
    for (const char* name : {"Pose-Applanix.mat", "Pose-Applanix.log"}) {
      std::error_code ignored;
      if (file.empty() && fs::exists(folder_ / name, ignored)) file = folder_ / name;
    }
    if (file.empty()) {
      note("there is no odometry: no file Pose-Applanix", folder_,
           "the daemon measures the motion with the lidar");
      return {};
    }
    const auto variables = read_mat_file(file, {"utime", "pos", "rph", "vel"});
    const auto poses =
        variables ? read_ford_poses(*variables, file.string()) : tl::unexpected(variables.error());
    if (!poses) {
      note("no odometry is taken: " + poses.error().what, file,
           "the thesis does not describe its text form; save the struct Pose as Pose-Applanix.mat");
      return {};
    }
    std::vector<WheelOdometry> samples;
    const Eigen::Isometry3d T_body_vehicle = ford_T_body_vehicle();
    for (size_t k = 1; k < poses->size(); ++k) {
      const FordPose &before = (*poses)[k - 1], &now = (*poses)[k];
      const double dt = to_seconds(now.stamp - before.stamp);
      WheelOdometry sample;
      sample.stamp = before.stamp + (now.stamp - before.stamp) / 2;
      sample.speed = (before.forward_speed + now.forward_speed) / 2;
      const Eigen::Matrix3d turn = T_body_vehicle.linear().transpose() *
                                   before.T_local_body.linear().transpose() *
                                   now.T_local_body.linear() * T_body_vehicle.linear();
      sample.yaw_rate = std::atan2(turn(1, 0), turn(0, 0)) / dt;
      samples.push_back(sample);
    }
    if (samples.empty()) return {};
    description_.speed = "speed.csv";
    summary_.speeds = samples.size();
    return recording::write_speed_csv(drive_ / "speed.csv", samples, true);
  }

  const fs::path folder_, drive_;
  recording::DriveDescription description_;
  FordImportSummary summary_;
};

}  // namespace

Result<FordImportSummary> import_ford(const fs::path& folder, const fs::path& drive) {
  return FordImport(folder, drive).run();
}

}  // namespace infuse::importers
