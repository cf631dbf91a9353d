#include "drivers/recording/drive.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/recording/drive_toml.hpp"
#include "drivers/recording/inside.hpp"
#include "drivers/recording/toml_table.hpp"
#include "drivers/text/quoted.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::recording {
namespace {

namespace fs = std::filesystem;

std::optional<std::string> check_path(const std::string& what, const std::string& path) {
  if (path.empty()) return std::nullopt;
  const std::string quoted = what + " '" + path + "'";
  if (path.size() > 4096 || path.find('\0') != std::string::npos)
    return what + " is not a valid path";
  const fs::path parts(path);
  if (parts.is_absolute()) return quoted + " must be relative to the drive's folder";
  if (std::find(parts.begin(), parts.end(), "..") != parts.end())
    return quoted + " must stay inside the drive's folder";
  return std::nullopt;
}

std::optional<std::string> check_lidar(const LidarMount& mount, const LidarFiles& files) {
  const std::string prefix = "lidar '" + mount.name + "': ";
  if (files.packets.empty() == files.sweeps.empty())
    return prefix + "either packets or sweeps must be given";
  if (files.sweeps.empty() && (files.turn || files.deskewed))
    return prefix + "rotation and deskewed are for sweeps; packets have their own times";
  if (files.turn && files.deskewed)
    return prefix + "give either rotation or deskewed: deskewed returns have one time";
  const auto is_angle = [](double degrees) { return std::abs(degrees) <= 360; };
  if (files.turn &&
      !(is_angle(files.turn->cut_deg) &&
        std::all_of(files.turn->ring_cuts_deg.begin(), files.turn->ring_cuts_deg.end(), is_angle)))
    return prefix + "cut_deg and ring_cuts_deg must lie within ±360";
  if (files.port == 0 || files.position_port == 0) return prefix + "a port must be 1 to 65535";
  if (files.port == files.position_port) return prefix + "port and position_port must differ";
  if (auto wrong = check_path(prefix + "packets", files.packets)) return wrong;
  if (auto wrong = check_path(prefix + "sweeps", files.sweeps)) return wrong;
  return check_path(prefix + "calibration", files.calibration);
}

// True if two lidars share a capture and differ neither in ports nor in sender.
bool overlap(const LidarFiles& a, const LidarFiles& b) {
  const bool same_sender = !a.sender || !b.sender || *a.sender == *b.sender;
  const bool shared_port = a.port == b.port || a.port == b.position_port ||
                           a.position_port == b.port || a.position_port == b.position_port;
  return !a.packets.empty() && a.packets == b.packets && same_sender && shared_port;
}

std::optional<std::string> check_can(const CanFiles& can) {
  if (can.log.empty() || can.dbc.empty()) return "can: both log and dbc must be given";
  if (auto wrong = check_path("can: log", can.log)) return wrong;
  if (auto wrong = check_path("can: dbc", can.dbc)) return wrong;
  const std::vector<std::string>& known = can_quantities();
  for (size_t i = 0; i < can.signals.size(); ++i) {
    const std::string& quantity = can.signals[i].quantity;
    if (std::find(known.begin(), known.end(), quantity) == known.end())
      return "can: unknown quantity '" + quantity + "'";
    for (size_t j = 0; j < i; ++j) {
      if (can.signals[j].quantity == quantity) return "can: two signals for " + quantity;
    }
  }
  return std::nullopt;
}

// A file or folder named in drive.toml.
struct ReferencedFile {
  std::string what;
  std::string path;
  bool folder;
};

std::vector<ReferencedFile> list_referenced_files(const DriveDescription& description) {
  std::vector<ReferencedFile> all;
  for (size_t i = 0; i < description.lidars.size(); ++i) {
    const std::string prefix = "lidar '" + description.rig.lidars[i].name + "': ";
    all.push_back({prefix + "packets", description.lidars[i].packets, false});
    all.push_back({prefix + "sweeps", description.lidars[i].sweeps, true});
    all.push_back({prefix + "calibration", description.lidars[i].calibration, false});
  }
  for (size_t i = 0; i < description.cameras.size(); ++i) {
    const std::string prefix = "camera '" + description.rig.cameras[i].name + "': ";
    all.push_back({prefix + "images", description.cameras[i].images, true});
  }
  if (description.can) {
    all.push_back({"can: log", description.can->log, false});
    all.push_back({"can: dbc", description.can->dbc, false});
  }
  all.push_back({"speed: file", description.speed, false});
  all.push_back({"imu: file", description.imu, false});
  all.push_back({"gnss: file", description.gnss, false});
  all.push_back({"map: file", description.map, false});
  all.push_back({"truth: poses", description.truth_poses, false});
  all.push_back({"truth: rig", description.truth_rig, false});
  return all;
}

}  // namespace

const std::vector<std::string>& can_quantities() {
  static const std::vector<std::string> names = {"wheel_speed_front_left",
                                                 "wheel_speed_front_right",
                                                 "wheel_speed_rear_left",
                                                 "wheel_speed_rear_right",
                                                 "speed",
                                                 "yaw_rate",
                                                 "steering_angle",
                                                 "steering_fraction",
                                                 "acceleration_forward",
                                                 "acceleration_left",
                                                 "acceleration_up",
                                                 "angular_velocity_forward",
                                                 "angular_velocity_left",
                                                 "angular_velocity_up",
                                                 "gear"};
  return names;
}

std::optional<std::string> DriveDescription::invalid() const {
  if (lidars.size() != rig.lidars.size() || cameras.size() != rig.cameras.size())
    return "the rig's sensors and their files do not match";
  if (auto wrong = rig.invalid()) return wrong;
  for (size_t i = 0; i < lidars.size(); ++i) {
    if (auto wrong = check_lidar(rig.lidars[i], lidars[i])) return wrong;
    for (size_t j = 0; j < i; ++j) {
      if (overlap(lidars[j], lidars[i])) {
        return "lidars '" + rig.lidars[j].name + "' and '" + rig.lidars[i].name +
               "' cannot be distinguished in '" + lidars[i].packets +
               "': set different ports or senders";
      }
    }
  }
  for (size_t i = 0; i < cameras.size(); ++i) {
    const std::string prefix = "camera '" + rig.cameras[i].name + "': ";
    if (cameras[i].images.empty()) return prefix + "images must be given";
    if (auto wrong = check_path(prefix + "images", cameras[i].images)) return wrong;
  }
  if (can) {
    if (auto wrong = check_can(*can)) return wrong;
  }
  if (auto wrong = check_path("speed: file", speed)) return wrong;
  if (auto wrong = check_path("imu: file", imu)) return wrong;
  if (auto wrong = check_path("gnss: file", gnss)) return wrong;
  if (!gnss_lidar.empty() && !gnss.empty()) return "gnss: give either file or lidar";
  if (!gnss_lidar.empty() && rig.find_lidar(gnss_lidar) == nullptr) {
    return "gnss: there is no lidar '" + gnss_lidar + "'";
  }
  if (auto wrong = check_path("map: file", map)) return wrong;
  if (auto wrong = check_path("truth: poses", truth_poses)) return wrong;
  return check_path("truth: rig", truth_rig);
}

Result<Drive> Drive::open(const fs::path& folder) {
  const fs::path file = folder / "drive.toml";
  if (std::error_code ignored; fs::is_regular_file(folder, ignored)) {
    return fail("is a file; a drive is a folder with a drive.toml", folder.string(),
                "infuse import folder makes one from a capture and images");
  }
  const auto text = text::read_text(file, kMaxTomlBytes);
  if (!text) return tl::unexpected(text.error());
  auto description = parse_drive(*text, file.string());
  if (!description) return tl::unexpected(description.error());

  Drive drive{folder, std::move(*description)};
  for (const ReferencedFile& named : list_referenced_files(drive.description)) {
    if (named.path.empty()) continue;
    std::error_code ignored;
    const fs::file_status status = fs::status(drive.resolve(named.path), ignored);
    const std::string what = named.what + " " + text::quoted(named.path);
    if (!fs::exists(status)) return fail(what + " does not exist", file.string());
    if (named.folder ? !fs::is_directory(status) : !fs::is_regular_file(status)) {
      return fail(what + " must be a " + (named.folder ? "folder" : "file"), file.string());
    }
    if (!lies_inside(folder, drive.resolve(named.path))) {
      return fail(what + " is a link out of the drive's folder", file.string(),
                  "copy the file into the folder");
    }
  }
  return drive;
}

Result<void> write_drive_toml(const fs::path& folder, const DriveDescription& description) {
  const fs::path file = folder / "drive.toml";
  if (const auto wrong = description.invalid()) return fail(*wrong, file.string());
  const std::string text = format_drive(description);
  // Detects text that TOML cannot represent, such as a name that is not UTF-8.
  if (const auto reparsed = parse_drive(text, file.string()); !reparsed)
    return tl::unexpected(reparsed.error());
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) return fail("cannot be created: " + failed.message(), folder.string());
  return text::write_text(file, text);
}

}  // namespace infuse::recording
