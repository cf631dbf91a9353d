#include "daemon/config/read_sensors.hpp"

#include <algorithm>

#include "drivers/makers/makers.hpp"
#include "drivers/recording/can_toml.hpp"

namespace infuse::daemon {
namespace {

using recording::TomlTable;

constexpr size_t kMaxSensors = 16;  // of one kind

std::optional<Error> read_lidar(TomlTable& table, const std::string&, LidarOptions& options) {
  table.read("model", options.model);
  if (const lidar::LidarModel* model = makers::find_model(options.model)) {
    options.port = model->maker->ports().data;
    options.position_port = model->maker->ports().information;
  }
  read_integer(table, "port", options.port);
  read_integer(table, "position_port", options.position_port);
  table.read("sender", options.sender);
  table.read("address", options.address);
  table.read("multicast", options.multicast);
  table.read("interface", options.interface);
  table.read("tap", options.tap);
  read_integer(table, "receive_buffer_bytes", options.receive_buffer);
  table.read("calibration", options.calibration);
  table.read("cut_azimuth_deg", options.cut_azimuth_deg);
  return std::nullopt;
}

void read_format(TomlTable& table, std::optional<camera::RawFormat>& format) {
  std::string name;
  table.read("format", name);
  if (name.empty()) return;
  format = camera::find_raw_format(name);
  if (!format) {
    table.report_error("format", "unknown format '" + name + "'",
                       "known: GREY, YUYV, UYVY, RGB24, BGR24, RGGB, BGGR, GBRG, GRBG, MJPEG");
  }
}

std::optional<Error> read_camera(TomlTable& table, const std::string&, CameraOptions& options) {
  camera::V4l2Options& stream = options.stream;
  table.read("device", stream.device);
  read_integer(table, "width", stream.width);
  read_integer(table, "height", stream.height);
  table.read("rate_hz", stream.rate_hz);
  read_format(table, stream.format);
  std::optional<double> exposure_ms, gain, delay_ms;
  table.read("exposure_ms", exposure_ms);
  table.read("gain", gain);
  table.read("stamp_delay_ms", delay_ms);
  if (exposure_ms) stream.exposure = from_seconds(*exposure_ms * 1e-3);
  if (delay_ms) stream.stamp_delay = from_seconds(*delay_ms * 1e-3);
  if (gain && !(*gain >= -2e9 && *gain <= 2e9)) table.report_error("gain", "gain is out of range");
  if (gain) stream.gain = static_cast<int>(std::clamp(*gain, -2e9, 2e9));
  return std::nullopt;
}

std::optional<Error> read_bus(TomlTable& table, const std::string& file, BusOptions& options) {
  table.read("interface", options.interface);
  table.read("dbc", options.dbc);
  table.read("reverse_gear", options.reverse_gear);
  const toml::table* signals = table.table("signals");
  if (signals == nullptr) return std::nullopt;
  options.signals.clear();
  return recording::read_can_signals(*signals, file, options.signals);
}

/// Returns the options of that name. `earlier`: number of sensors read from earlier files.
template <class Options>
Options& find_or_add(std::vector<Options>& sensors, size_t earlier, const std::string& name) {
  const auto end = sensors.begin() + static_cast<std::ptrdiff_t>(earlier);
  const auto found =
      std::find_if(sensors.begin(), end, [&](const Options& o) { return o.name == name; });
  if (found != end) return *found;
  sensors.emplace_back().name = name;
  return sensors.back();
}

template <class Options>
std::optional<Error> read_kind(TomlTable& root, const std::string& file, const char* kind,
                               std::optional<Error> (*read)(TomlTable&, const std::string&,
                                                            Options&),
                               std::vector<Options>& sensors) {
  const size_t earlier = sensors.size();
  std::vector<std::string> names;
  for (const toml::table* source : root.tables(kind, kMaxSensors)) {
    TomlTable table(*source, file, kind);
    std::string name = Options{}.name;
    table.read("name", name);
    if (std::find(names.begin(), names.end(), name) != names.end()) {
      return Error{std::string("two ") + kind + "s are named '" + name + "'",
                   file + ":" + std::to_string(source->source().begin.line),
                   "give each a unique name"};
    }
    names.push_back(name);
    if (names.size() + earlier > kMaxSensors) {
      table.report_table_error(std::string("more than 16 ") + kind + "s");
    }
    Options& options = find_or_add(sensors, earlier, name);
    options.source = file + ":" + std::to_string(source->source().begin.line);
    if (auto error = read(table, file, options)) return error;
    if (const auto wrong = options.invalid()) {
      table.report_table_error(std::string(kind) + ": " + *wrong);
    }
    if (auto error = table.finish()) return error;
  }
  return std::nullopt;
}

}  // namespace

std::optional<Error> read_sensors(TomlTable& root, const std::string& file, Config& config) {
  if (auto error = read_kind(root, file, "lidar", read_lidar, config.lidars)) return error;
  if (auto error = read_kind(root, file, "camera", read_camera, config.cameras)) return error;
  if (auto error = read_kind(root, file, "can", read_bus, config.buses)) return error;
  if (const toml::table* source = root.table("gnss")) {
    TomlTable table(*source, file, "gnss");
    table.read("device", config.gnss.device);
    table.read("lidar", config.gnss.lidar);
    read_integer(table, "baud", config.gnss.baud);
    if (const auto wrong = config.gnss.invalid()) table.report_table_error("gnss: " + *wrong);
    return table.finish();
  }
  return std::nullopt;
}

}  // namespace infuse::daemon
