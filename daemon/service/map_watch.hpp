#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <future>
#include <optional>
#include <stop_token>
#include <string>

#include "daemon/health/host_alerts.hpp"
#include "daemon/process/idle_time.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Watches what lies in the place of a map in use, and takes over a whole new one. A damaged or
/// incomplete one is refused and tried again, ever more rarely: a copy may be under way.
class MapWatch {
 public:
  using Clock = std::chrono::steady_clock;
  /// Reads and checks the map that lies in place, puts it in use unless it is the one that is, of
  /// the digest `in_use`, and returns its digest; soon after a stop was requested, anything. Runs
  /// on a thread of its own with the lowest priority.
  using Replace =
      std::function<Result<std::string>(const std::string& in_use, const std::stop_token& stop)>;

  /// `file`: the file of the map that a new map replaces last. `digest`: of the map in use.
  MapWatch(std::string name, std::filesystem::path file, std::string digest, Replace replace);

  ~MapWatch() {
    stop_.request_stop();
    idle_.end();
  }
  MapWatch(const MapWatch&) = delete;
  MapWatch& operator=(const MapWatch&) = delete;

  /// To be called each second. A change that has lasted from one call to the next is looked at; at
  /// first what lies there, which may have changed since the map was opened.
  void poll(Clock::time_point now);

  /// What was refused is tried again at the next `poll`.
  void try_again() {
    if (!in_use_.problem.empty()) due_ = Clock::time_point::min();
  }
  /// True while a map is being looked at.
  bool looks() const;

  const MapInUse& in_use() const { return in_use_; }

 private:
  /// What tells two files of one name apart.
  struct Mark {
    uint64_t device = 0, inode = 0;
    int64_t bytes = -1, changed_ns = 0;
    bool operator==(const Mark&) const = default;
  };

  Mark mark() const;
  void settle(Clock::time_point now);

  std::filesystem::path file_;
  MapInUse in_use_;
  Replace replace_;
  std::optional<Mark> looked_at_;  // nothing: not yet
  Mark seen_;
  Clock::time_point due_ = Clock::time_point::max();  // of the next look without a change
  std::chrono::seconds pause_{0};                     // before it
  std::stop_source stop_;
  IdleTime idle_;
  std::future<Result<std::string>> looking_;  // last member: its thread uses the others
};

}  // namespace infuse::daemon
