#pragma once

#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "daemon/pipeline/replay.hpp"
#include "daemon/setup/drive_setup.hpp"

namespace infuse::daemon {

/// A temporary folder, removed at the end.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    path_ = std::filesystem::temp_directory_path() /
            ("infuse-test-" + std::to_string(::getpid()) + "-" + std::to_string(++made_));
    std::filesystem::create_directories(path_);
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  static inline int made_ = 0;
  std::filesystem::path path_;
};

/// Result of a replay.
struct ReplayResult {
  Totals totals;
  std::vector<Sensor> sensors;
  std::vector<Error> notes;
  std::string reports;  ///< bytes of the reports file

  /// The reports, one line each.
  std::vector<std::string> lines() const {
    std::vector<std::string> lines;
    std::istringstream stream(reports);
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
  }
};

/// Options of `run_replay`.
struct RunReplayOptions {
  std::optional<double> rate = {};
  std::filesystem::path socket = {};                         ///< empty: no socket
  std::optional<std::chrono::milliseconds> stop_after = {};  ///< host time
  PipelineOptions pipeline = {};
};

/// Replays a drive from its start to its end.
inline Result<ReplayResult> run_replay(const std::filesystem::path& path,
                                       const RunReplayOptions& options = {}) {
  const TemporaryFolder folder;
  auto setup = open_drive(path, {}, {});
  if (!setup) return tl::unexpected(setup.error());
  auto file = ReportsFile::create(folder / "reports");
  if (!file) return tl::unexpected(file.error());
  boost::asio::io_context io(1);
  Server server(io, {}, "0", "0123456789abcdef");
  if (!options.socket.empty()) {
    if (auto listening = server.listen(options.socket); !listening) {
      return tl::unexpected(listening.error());
    }
  }
  boost::asio::steady_timer stop(io);
  Replay replay(io, *std::move(setup), {options.rate, options.pipeline}, server, &*file, [&] {
    stop.cancel();
    server.finish(std::chrono::seconds(5));
  });
  replay.start();
  if (options.stop_after) {
    stop.expires_after(*options.stop_after);
    stop.async_wait([&](boost::system::error_code error) {
      if (!error) replay.stop();
    });
  }
  io.run();
  if (auto closed = file->close(); !closed) return tl::unexpected(closed.error());
  std::ifstream stream(folder / "reports", std::ios::binary);
  std::stringstream bytes;
  bytes << stream.rdbuf();
  return ReplayResult{replay.totals(), replay.setup().sensors(), replay.notes(), bytes.str()};
}

}  // namespace infuse::daemon
