#include "drivers/recording/drive_toml.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "drivers/measurement/ipv4_address.hpp"
#include "drivers/recording/can_toml.hpp"
#include "drivers/recording/drive_table.hpp"
#include "drivers/recording/rig_checks.hpp"
#include "drivers/recording/sweep_files.hpp"
#include "drivers/recording/toml_names.hpp"
#include "drivers/recording/toml_table.hpp"
#include "drivers/text/printable.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::recording {
namespace {

constexpr size_t kMaxSensors = 64;
constexpr double kMaxReadoutMs = 200;  // the slowest sensors read five images a second

template <class Value, size_t size>
void read_enum(TomlTable& table, std::string_view key,
               const std::array<std::pair<std::string_view, Value>, size>& names, Value& value) {
  std::string name;
  table.read(key, name);
  if (table.node(key) == nullptr) return;
  std::string all;
  for (const auto& [known, meaning] : names) {
    if (known == name) {
      value = meaning;
      return;
    }
    all += (all.empty() ? "\"" : ", \"") + std::string(known) + "\"";
  }
  table.report_error(key, std::string(key) + " must be one of " + all);
}

void read_port(TomlTable& table, std::string_view key, uint16_t& port) {
  int64_t number = port;
  table.read(key, 1, 65535, number);
  port = static_cast<uint16_t>(number);
}

void read_sender(TomlTable& table, std::optional<uint32_t>& sender) {
  std::string text;
  table.read("sender", text);
  if (table.node("sender") == nullptr) return;
  sender = parse_address(text);
  if (!sender) {
    table.report_error("sender", "sender must be an IPv4 address", "for example \"192.168.1.201\"");
  }
}

void read_name(TomlTable& table, std::string& name) {
  table.read("name", name);
  if (!text::is_name(name)) table.report_error("name", text::kNameRule);
}

void read_mount(TomlTable& table, LidarMount& mount) {
  table.require("name");
  table.require("T_vehicle_lidar");
  read_name(table, mount.name);
  table.read("model", mount.model);
  table.read("T_vehicle_lidar", mount.T_vehicle_lidar);
}

void read_files(TomlTable& table, LidarFiles& files) {
  table.read("packets", files.packets);
  table.read("sweeps", files.sweeps);
  read_port(table, "port", files.port);
  read_port(table, "position_port", files.position_port);
  read_sender(table, files.sender);
  table.read("calibration", files.calibration);
  if (table.node("rotation") != nullptr) {
    Turn turn;
    read_enum(table, "rotation", kRotations, turn.clockwise);
    table.read("cut_deg", turn.cut_deg);
    table.read("ring_cuts_deg", kMaxRings, turn.ring_cuts_deg);
    files.turn = turn;
  }
  table.read("deskewed", files.deskewed);
}

void read_intrinsics(TomlTable& table, CameraIntrinsics& intrinsics) {
  for (const char* key : {"width", "height", "fx", "fy", "cx", "cy"}) table.require(key);
  read_enum(table, "model", kCameraModels, intrinsics.model);
  int64_t width = 0, height = 0;
  table.read("width", 1, 65536, width);
  table.read("height", 1, 65536, height);
  intrinsics.width = static_cast<int>(width);
  intrinsics.height = static_cast<int>(height);
  table.read("fx", intrinsics.fx);
  table.read("fy", intrinsics.fy);
  table.read("cx", intrinsics.cx);
  table.read("cy", intrinsics.cy);
  const bool fisheye = intrinsics.model == CameraIntrinsics::Model::kFisheye;
  std::vector<double> distortion;
  table.read("distortion", fisheye ? 4 : 5, distortion);
  std::copy(distortion.begin(), distortion.end(), intrinsics.distortion.begin());
}

/// The numbers of `infuse calibrate --intrinsics-sigma`: %, px, k1.
void read_intrinsics_sigma(TomlTable& table, std::optional<IntrinsicsSigma>& sigma) {
  constexpr const char* kKey = "intrinsics_sigma";
  if (table.node(kKey) == nullptr) return;
  std::vector<double> numbers;
  table.read(kKey, 3, numbers);
  constexpr std::array<double, 3> kMost{10, 100, 1};
  const auto is_within = [](double x, double most) { return x >= 0 && x <= most; };
  if (numbers.size() != 3 || !std::ranges::equal(numbers, kMost, is_within)) {
    return table.report_error(
        kKey, std::string(kKey) + " must be three numbers: 0 ... 10 %, 0 ... 100 px, 0 ... 1");
  }
  sigma = {numbers[0] / 100, numbers[1], numbers[2]};
}

/// Reads `name`_ms and `name`_sigma_ms.
void read_delay(TomlTable& table, const std::string& name, Duration& delay, Duration& sigma) {
  const auto read = [&](const std::string& key, double least, const char* range, Duration& value) {
    double ms = 0;
    table.read(key, ms);
    if (!(ms >= least && ms <= 10'000)) table.report_error(key, key + range);
    value = from_seconds(ms * 1e-3);
  };
  read(name + "_ms", -10'000, " must lie within ±10000", delay);
  read(name + "_sigma_ms", 0, " must be 0 ... 10000", sigma);
}

void read_mount(TomlTable& table, CameraMount& mount) {
  for (const char* key : {"name", "lidar", "T_camera_lidar"}) table.require(key);
  read_name(table, mount.name);
  read_intrinsics(table, mount.intrinsics);
  read_intrinsics_sigma(table, mount.intrinsics_sigma);
  table.read("lidar", mount.lidar);
  table.read("T_camera_lidar", mount.T_camera_lidar);
  read_delay(table, "stamp_delay", mount.stamp_delay, mount.stamp_delay_sigma);
  double readout_ms = 0;
  table.read("readout_ms", readout_ms);
  if (!(readout_ms >= -kMaxReadoutMs && readout_ms <= kMaxReadoutMs))
    table.report_error("readout_ms", "readout_ms must be between -200 and 200");
  mount.readout = from_seconds(readout_ms * 1e-3);
}

void read_files(TomlTable& table, CameraFiles& files) {
  table.read("images", files.images);
  PixelFormat mosaic = PixelFormat::kGrey8;
  read_enum(table, "mosaic", kMosaics, mosaic);
  if (mosaic != PixelFormat::kGrey8) files.mosaic = mosaic;
  table.read("grey", files.grey);
}

std::optional<Error> read_can(const toml::table& source, const std::string& file, CanFiles& can) {
  TomlTable table(source, file, "can");
  table.require("log");
  table.require("dbc");
  table.read("log", can.log);
  table.read("dbc", can.dbc);
  table.read("interface", can.interface);
  table.read("reverse_gear", can.reverse_gear);
  const toml::table* signals = table.table("signals");
  if (auto wrong = table.finish()) return wrong;
  if (signals == nullptr) return std::nullopt;
  return read_can_signals(*signals, file, can.signals);
}

// Reads one of the tables [speed], [gnss], [map], [truth], which contain only paths.
std::optional<Error> read_paths(TomlTable& root, const std::string& file, std::string_view name,
                                std::initializer_list<std::pair<const char*, std::string*>> keys) {
  const toml::table* source = root.table(name);
  if (source == nullptr) return std::nullopt;
  TomlTable table(*source, file, std::string(name));
  for (const auto& [key, path] : keys) table.read(key, *path);
  return table.finish();
}

// Reads all sensors of one kind. `files` is a vector of LidarFiles or CameraFiles, or null in a
// rig.toml. `check` validates everything read so far after each sensor, so that its error carries
// that sensor's line.
template <class Mount, class Check>
std::optional<Error> read_sensors(TomlTable& root, const std::string& file, const char* key,
                                  std::vector<Mount>& mounts, auto* files, const Check& check) {
  for (const toml::table* source : root.tables(key, kMaxSensors)) {
    TomlTable table(*source, file, key);
    read_mount(table, mounts.emplace_back());
    if constexpr (!std::is_same_v<decltype(files), std::nullptr_t*>) {
      read_files(table, files->emplace_back());
    }
    if (auto wrong = table.finish()) return wrong;
    if (const auto wrong = check()) table.report_table_error(*wrong);
    if (auto wrong = table.finish()) return wrong;
  }
  return std::nullopt;
}

std::optional<Error> read_drive(const toml::table& source, const std::string& file,
                                DriveDescription& drive) {
  TomlTable root(source, file, "the drive");
  const auto check = [&] { return drive.invalid(); };
  root.read("name", drive.name);
  read_enum(root, "times", kTimes, drive.times_trusted);
  if (auto wrong = read_sensors(root, file, "lidar", drive.rig.lidars, &drive.lidars, check))
    return wrong;
  if (auto wrong = read_sensors(root, file, "camera", drive.rig.cameras, &drive.cameras, check))
    return wrong;
  if (const toml::table* can = root.table("can")) {
    if (auto wrong = read_can(*can, file, drive.can.emplace())) return wrong;
  }
  if (auto wrong = read_paths(root, file, "speed", {{"file", &drive.speed}})) return wrong;
  if (const toml::table* imu = root.table("imu")) {
    TomlTable table(*imu, file, "imu");
    table.read("file", drive.imu);
    read_delay(table, "delay", drive.imu_delay, drive.imu_delay_sigma);
    if (auto wrong = table.finish()) return wrong;
  }
  for (const char* name : {"gps", "gnss"}) {  // gps: drives of earlier versions
    if (auto wrong =
            read_paths(root, file, name, {{"file", &drive.gnss}, {"lidar", &drive.gnss_lidar}})) {
      return wrong;
    }
  }
  if (auto wrong = read_paths(root, file, "map", {{"file", &drive.map}})) return wrong;
  if (auto wrong = read_paths(root, file, "truth",
                              {{"poses", &drive.truth_poses}, {"rig", &drive.truth_rig}}))
    return wrong;
  return root.finish();
}

template <bool of_vehicle>
std::optional<Error> read_rig_tables(const toml::table& source, const std::string& file, Rig& rig) {
  TomlTable root(source, file, "the rig");
  const auto check = [&](const auto& mounts) {
    auto wrong = rig.invalid();
    return wrong || !of_vehicle ? wrong : find_impossible(mounts.back());
  };
  std::nullptr_t* no_files = nullptr;
  auto wrong =
      read_sensors(root, file, "lidar", rig.lidars, no_files, [&] { return check(rig.lidars); });
  if (wrong) return wrong;
  wrong =
      read_sensors(root, file, "camera", rig.cameras, no_files, [&] { return check(rig.cameras); });
  return wrong ? wrong : root.finish();
}

template <class Value, class Read>
Result<Value> parse(std::string_view text, const std::string& file, const Read& read) {
  const auto table = parse_toml(text, file);
  if (!table) return tl::unexpected(table.error());
  Value value;
  if (auto wrong = read(*table, file, value)) return tl::unexpected(std::move(*wrong));
  return value;
}

}  // namespace

Result<DriveDescription> parse_drive(const toml::table& table, const std::string& file) {
  DriveDescription drive;
  if (auto wrong = read_drive(table, file, drive)) return tl::unexpected(std::move(*wrong));
  if (const auto wrong = drive.invalid()) return fail(*wrong, file);
  return drive;
}

Result<DriveDescription> parse_drive(std::string_view text, const std::string& file) {
  const auto table = parse_toml(text, file);
  if (!table) return tl::unexpected(table.error());
  return parse_drive(*table, file);
}

Result<Rig> parse_rig(std::string_view text, const std::string& file) {
  return parse<Rig>(text, file, read_rig_tables<false>);
}

Result<Rig> read_rig(const std::filesystem::path& path) {
  const auto text = text::read_text(path, kMaxTomlBytes);
  if (!text) return tl::unexpected(text.error());
  return parse_rig(*text, path.string());
}

Result<Rig> read_vehicle_rig(const std::filesystem::path& path) {
  const auto text = text::read_text(path, kMaxTomlBytes);
  if (!text) return tl::unexpected(text.error());
  return parse<Rig>(*text, path.string(), read_rig_tables<true>);
}

Result<void> write_rig(const std::filesystem::path& path, const Rig& rig) {
  if (const auto wrong = rig.invalid()) return fail(*wrong, path.string());
  return text::write_text(path, format_rig(rig));
}

}  // namespace infuse::recording
