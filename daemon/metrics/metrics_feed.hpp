#pragma once

#include "daemon/config/config.hpp"
#include "daemon/metrics/metrics_server.hpp"
#include "daemon/metrics/metrics_text.hpp"

namespace infuse::daemon {

/// Keeps the text of a server up to date.
class MetricsFeed {
 public:
  /// `server` outlives this. `release`: the program's version.
  MetricsFeed(MetricsServer& server, std::string release, const Config& config) : server_(server) {
    process_.release = std::move(release);
    process_.config_digest = config.digest;
    process_.config_version = config.version;
  }

  void add(const AlertReport& alert) { process_.alerts += alert.raised ? 1 : 0; }
  void add(const CalibrationReport&) {}
  /// Makes the text.
  void add(const HealthReport& health) {
    measure_process(process_);
    server_.set_text(metrics_text(health, process_));
  }

 private:
  MetricsServer& server_;
  ProcessStats process_;
};

}  // namespace infuse::daemon
