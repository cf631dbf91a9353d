#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "daemon/protocol/number_json.hpp"
#include "daemon/tools/fleet/drive_entry.hpp"
#include "daemon/tools/fleet/json_fields.hpp"

namespace infuse::daemon::fleet_files {

/// A folder that is removed at the end.
class Folder {
 public:
  Folder() {
    static int count = 0;
    path_ = std::filesystem::temp_directory_path() /
            ("infuse-fleet-" + std::to_string(::getpid()) + "-" + std::to_string(count++));
    std::filesystem::create_directories(path_);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  const std::filesystem::path& path() const { return path_; }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name) << text;
  }
  void write_step(const std::string& name, int code, const std::string& output,
                  const std::string& log) const {
    write(name + ".code", std::to_string(code) + "\n");
    write(name + ".json", output);
    write(name + ".log", log);
  }

 private:
  std::filesystem::path path_;
};

/// What infuse calibrate prints: the camera is `moved` from the identity; σ is 0.04° and 5 mm by
/// the scenes, and 0.1° more about x by the intrinsics.
inline Json calibrate_output(const geometry::Vector6& moved, double cpu_s = 1) {
  geometry::Matrix6 scenes = geometry::Matrix6::Identity();
  scenes.topLeftCorner<3, 3>() *= 7e-4 * 7e-4;
  scenes.bottomRightCorner<3, 3>() *= 5e-3 * 5e-3;
  geometry::Matrix6 all = scenes;
  all(0, 0) += 1.7e-3 * 1.7e-3;
  return {
      {"camera", "front"},
      {"lidar", "top"},
      {"usable", true},
      {"reason", ""},
      {"cpu_s", cpu_s},
      {"T_camera_lidar", by_row(geometry::exp(moved).matrix())},
      {"covariance", rows_json(all)},
      {"covariance_of_scenes", rows_json(scenes)},
      {"covariance_of_motion", rows_json(geometry::Matrix6::Zero())},
      {"scenes", {{{"stamp", 1'772'352'007'000'000'000}}, {{"stamp", 1'772'352'003'000'000'000}}}}};
}

/// An entry as infuse fleet drive makes it, parsed.
inline DriveEntry entry(const std::string& vehicle, const std::string& drive,
                        const std::string& date, const geometry::Vector6& moved) {
  const Folder folder;
  folder.write_step("calibrate", 0, calibrate_output(moved).dump(), "");
  const auto made = make_drive_entry(folder.path(), {vehicle, drive, date});
  return parse_drive_entry(made->dump(), "entry").value();
}

}  // namespace infuse::daemon::fleet_files
