#include <cstdio>
#include <span>

#include "drivers/recording/drive_toml.hpp"
#include "drivers/recording/toml_names.hpp"
#include "drivers/text/numbers.hpp"

namespace infuse::recording {
namespace {

std::string format_string(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      result += {'\\', c};
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) {
      std::array<char, 8> escape{};
      std::snprintf(escape.data(), escape.size(), "\\u%04X", static_cast<unsigned>(c));
      result += escape.data();
    } else {
      result += c;
    }
  }
  return result + '"';
}

std::string format_number(double value) {
  std::string digits;
  text::append_number(digits, value);
  return digits;
}

std::string format_numbers(std::span<const double> values) {
  std::string result = "[";
  for (size_t i = 0; i < values.size(); ++i)
    result += (i == 0 ? "" : ", ") + format_number(values[i]);
  return result + "]";
}

void add(std::string& text, const char* key, const std::string& value) {
  text += std::string(key) + " = " + value + "\n";
}

void add_text(std::string& text, const char* key, const std::string& value) {
  if (!value.empty()) add(text, key, format_string(value));
}

void add_ms(std::string& text, const char* key, Duration value) {
  if (value == Duration::zero()) return;
  add(text, key, format_number(static_cast<double>(value.count()) / 1e6));
}

void add_transform(std::string& text, const char* key, const Eigen::Isometry3d& T) {
  text += std::string(key) + " = [\n";
  for (int row = 0; row < 4; ++row) {
    text += "  ";
    for (int column = 0; column < 4; ++column) {
      text += format_number(T.matrix()(row, column)) + (row == 3 && column == 3 ? "" : ",") +
              (column == 3 ? "\n" : " ");
    }
  }
  text += "]\n";
}

template <class Value, size_t size>
std::string format_enum(const std::array<std::pair<std::string_view, Value>, size>& names,
                        Value value) {
  for (const auto& [name, meaning] : names) {
    if (meaning == value) return format_string(name);
  }
  return format_string("");
}

std::string format_ipv4(uint32_t address) {
  return std::to_string(address >> 24) + "." + std::to_string(address >> 16 & 0xFF) + "." +
         std::to_string(address >> 8 & 0xFF) + "." + std::to_string(address & 0xFF);
}

void add_mount(std::string& text, const LidarMount& mount) {
  text += "\n[[lidar]]\n";
  add_text(text, "name", mount.name);
  add_text(text, "model", mount.model);
  add_transform(text, "T_vehicle_lidar", mount.T_vehicle_lidar);
}

void add_files(std::string& text, const LidarFiles& files) {
  add_text(text, "packets", files.packets);
  add_text(text, "sweeps", files.sweeps);
  if (!files.packets.empty()) {
    add(text, "port", std::to_string(files.port));
    add(text, "position_port", std::to_string(files.position_port));
  }
  if (files.sender) add(text, "sender", format_string(format_ipv4(*files.sender)));
  add_text(text, "calibration", files.calibration);
  if (files.turn) {
    add(text, "rotation", format_enum(kRotations, files.turn->clockwise));
    add(text, "cut_deg", format_number(files.turn->cut_deg));
    if (!files.turn->ring_cuts_deg.empty())
      add(text, "ring_cuts_deg", format_numbers(files.turn->ring_cuts_deg));
  }
  if (files.deskewed) add(text, "deskewed", "true");
}

void add_mount(std::string& text, const CameraMount& mount) {
  const CameraIntrinsics& intrinsics = mount.intrinsics;
  const bool fisheye = intrinsics.model == CameraIntrinsics::Model::kFisheye;
  text += "\n[[camera]]\n";
  add_text(text, "name", mount.name);
  add(text, "model", format_enum(kCameraModels, intrinsics.model));
  add(text, "width", std::to_string(intrinsics.width));
  add(text, "height", std::to_string(intrinsics.height));
  add(text, "fx", format_number(intrinsics.fx));
  add(text, "fy", format_number(intrinsics.fy));
  add(text, "cx", format_number(intrinsics.cx));
  add(text, "cy", format_number(intrinsics.cy));
  add(text, "distortion", format_numbers(std::span(intrinsics.distortion).first(fisheye ? 4 : 5)));
  if (const auto& sigma = mount.intrinsics_sigma) {
    add(text, "intrinsics_sigma",
        format_numbers(
            std::array{100 * sigma->focal_length, sigma->principal_point, sigma->radial}));
  }
  add_text(text, "lidar", mount.lidar);
  add_transform(text, "T_camera_lidar", mount.T_camera_lidar);
  add_ms(text, "stamp_delay_ms", mount.stamp_delay);
  add_ms(text, "stamp_delay_sigma_ms", mount.stamp_delay_sigma);
  add_ms(text, "readout_ms", mount.readout);
}

void add_files(std::string& text, const CameraFiles& files) {
  add_text(text, "images", files.images);
  if (files.mosaic) add(text, "mosaic", format_enum(kMosaics, *files.mosaic));
  if (files.grey) add(text, "grey", "true");
}

void add_can(std::string& text, const CanFiles& can) {
  text += "\n[can]\n";
  add_text(text, "log", can.log);
  add_text(text, "dbc", can.dbc);
  add_text(text, "interface", can.interface);
  if (can.reverse_gear) add(text, "reverse_gear", format_number(*can.reverse_gear));
  if (can.signals.empty()) return;
  text += "\n[can.signals]\n";
  for (const CanSignal& signal : can.signals) {
    std::string value = "{ signal = " + format_string(signal.signal);
    if (signal.scale != 1) value += ", scale = " + format_number(signal.scale);
    if (!signal.unit.empty()) value += ", unit = " + format_string(signal.unit);
    add(text, signal.quantity.c_str(), value + " }");
  }
}

void add_path_table(std::string& text, const char* name, const std::string& path) {
  if (path.empty()) return;
  text += std::string("\n[") + name + "]\n";
  add_text(text, "file", path);
}

}  // namespace

std::string format_drive(const DriveDescription& drive) {
  std::string text;
  add_text(text, "name", drive.name);
  add(text, "times", format_enum(kTimes, drive.times_trusted));
  for (size_t i = 0; i < drive.lidars.size(); ++i) {
    add_mount(text, drive.rig.lidars[i]);
    add_files(text, drive.lidars[i]);
  }
  for (size_t i = 0; i < drive.cameras.size(); ++i) {
    add_mount(text, drive.rig.cameras[i]);
    add_files(text, drive.cameras[i]);
  }
  if (drive.can) add_can(text, *drive.can);
  add_path_table(text, "speed", drive.speed);
  add_path_table(text, "imu", drive.imu);
  add_ms(text, "delay_ms", drive.imu_delay);
  add_ms(text, "delay_sigma_ms", drive.imu_delay_sigma);
  add_path_table(text, "gnss", drive.gnss);
  if (!drive.gnss_lidar.empty()) {
    text += "\n[gnss]\n";
    add_text(text, "lidar", drive.gnss_lidar);
  }
  add_path_table(text, "map", drive.map);
  if (!drive.truth_poses.empty() || !drive.truth_rig.empty()) {
    text += "\n[truth]\n";
    add_text(text, "poses", drive.truth_poses);
    add_text(text, "rig", drive.truth_rig);
  }
  return text;
}

std::string format_rig(const Rig& rig) {
  std::string text;
  for (const LidarMount& mount : rig.lidars) add_mount(text, mount);
  for (const CameraMount& mount : rig.cameras) add_mount(text, mount);
  return text;
}

}  // namespace infuse::recording
