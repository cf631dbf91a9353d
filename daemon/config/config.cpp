#include "daemon/config/config.hpp"

#include <algorithm>
#include <array>
#include <fstream>

#include "daemon/config/toml_reader.hpp"

namespace infuse::daemon {
namespace {

constexpr size_t kMaxConfigBytes = 1 << 20;
constexpr std::array kLogLevels = {"trace", "debug", "info", "warning", "error", "off"};

void read_socket(TomlReader& table, ServerOptions& options) {
  table.read("path", options.path);
  table.read<uint16_t>("tcp_port", options.tcp_port, 0, 65535);
  table.read<uint32_t>("max_clients", options.max_clients, 0, UINT32_MAX);
  table.read_seconds("idle_timeout_s", options.idle_timeout);
  table.read<uint32_t>("queue_reports", options.queue_reports, 0, UINT32_MAX);
  table.read("max_requests_hz", options.max_requests_hz);
}

void read_health(TomlReader& table, HealthOptions& options) {
  table.read_seconds("stale_after_s", options.stale_after);
  table.read_seconds("raise_after_s", options.raise_after);
  table.read_seconds("clear_after_s", options.clear_after);
  table.read_seconds("clock_grace_s", options.clock_grace);
  table.read("warn_loss", options.warn_loss);
  table.read("error_loss", options.error_loss);
}

void read_lidar(TomlReader& table, LidarOptions& options) {
  table.read("name", options.name);
  table.read("model", options.model);
  table.read<uint16_t>("port", options.port, 1, 65535);
  table.read("sender", options.sender);
  table.read("calibration", options.calibration);
  table.read("cut_azimuth_deg", options.cut_azimuth_deg);
}

/// Reads one table into options and checks them as a whole.
template <class Options>
std::optional<Error> read_table(const toml::table* table, const std::string& file,
                                const std::string& name, void (*read)(TomlReader&, Options&),
                                Options& options) {
  if (table == nullptr) return std::nullopt;
  TomlReader reader(*table, file, name);
  read(reader, options);
  if (const auto wrong = options.invalid()) reader.wrong(*wrong);
  return reader.error();
}

std::optional<Error> read_all(TomlReader& root, const std::string& file, Config& config) {
  root.read("log_level", config.log_level);
  if (std::find(kLogLevels.begin(), kLogLevels.end(), config.log_level) == kLogLevels.end()) {
    root.wrong("log_level is none of trace, debug, info, warning, error, off");
  }
  const toml::table* socket = root.table("socket");
  const toml::table* health = root.table("health");
  const auto lidars = root.tables("lidar");
  if (auto error = root.error()) return error;
  if (auto error = read_table(socket, file, "socket", read_socket, config.socket)) return error;
  if (auto error = read_table(health, file, "health", read_health, config.health)) return error;
  for (const toml::table* lidar : lidars) {
    LidarOptions options;
    if (auto error = read_table(lidar, file, "lidar", read_lidar, options)) return error;
    const auto same = std::find_if(config.lidars.begin(), config.lidars.end(),
                                   [&](const auto& other) { return other.name == options.name; });
    if (same != config.lidars.end()) {
      return Error{"two lidars are named '" + options.name + "'", place_in(file, lidar->source()),
                   "give each a name of its own"};
    }
    config.lidars.push_back(std::move(options));
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> LidarOptions::invalid() const {
  if (name.empty()) return "name is empty";
  if (!(cut_azimuth_deg >= 0 && cut_azimuth_deg < 360)) {
    return "cut_azimuth_deg must lie in 0 ... 360";
  }
  return std::nullopt;
}

Result<Config> parse_config(std::string_view text, const std::string& file) {
  if (text.size() > kMaxConfigBytes) return fail("the file is larger than 1 MiB", file);
  const toml::parse_result parsed = toml::parse(text, file);
  if (!parsed) {
    return fail(std::string(parsed.error().description()), place_in(file, parsed.error().source()));
  }
  Config config;
  TomlReader root(parsed.table(), file, "");
  if (auto error = read_all(root, file, config)) return tl::unexpected(*std::move(error));
  return config;
}

Result<Config> load_config(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string text(kMaxConfigBytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad() || (stream.fail() && !stream.eof())) {
    return fail("the configuration cannot be read", path.string(), "does the file exist?");
  }
  text.resize(static_cast<size_t>(stream.gcount()));
  return parse_config(text, path.string());
}

}  // namespace infuse::daemon
