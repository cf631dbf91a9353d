#include "daemon/owner/readiness.hpp"

#include <chrono>
#include <thread>

#include "daemon/owner/client.hpp"
#include "daemon/owner/report_text.hpp"

namespace infuse::daemon {
namespace {

using Clock = std::chrono::steady_clock;

/// "top: no data from port 2368 for 30.1 s": the first finding of a HEALTH message that keeps the
/// daemon from being ready; empty without one. A drifted calibration does not: it takes a drive to
/// mend.
std::string first_problem(const Json& health) {
  for (const NamedFinding& each : findings_of(health)) {
    if (!each.of_calibration && level_of(each.finding, "level") >= Level::kError) {
      return each.device + ": " + text_of(each.finding, "what");
    }
  }
  return "";
}

/// Readiness of a daemon by its reports.
struct Readiness {
  std::string missing = "the daemon";  // what has not delivered data
  std::string level;                   // of the last HEALTH report
  std::string problem;
  bool delivering = false;  // every device has delivered data
  bool healthy = false;

  void update(const Json& report) {
    const std::string name = report.value("class", "");
    if (name == "DEVICES") update_devices(report);
    if (name == "HEALTH") {
      level = report.value("level", "");
      problem = first_problem(report);
      healthy = problem.empty();
    }
  }
  void update_devices(const Json& report) {
    if (report.value("devices", Json::array()).empty()) {
      delivering = false;
      missing = "a sensor: none is configured";
      return;
    }
    missing.clear();
    for (const Json& device : report.value("devices", Json::array())) {
      if (device.contains("activated")) continue;
      missing += (missing.empty() ? "" : ", ") + device.value("device", "");
    }
    delivering = missing.empty();
  }
  /// What is not ready: "top, front (top: no data from port 2368 for 30.1 s)".
  std::string waiting_for() const {
    const std::string first = !delivering     ? missing
                              : level.empty() ? "a HEALTH report"
                                              : "OK or WARN, HEALTH is " + level;
    return first + (problem.empty() ? "" : " (" + problem + ")");
  }
};

/// Reads one connection until the daemon is ready, it ends, or the time is over.
bool reads_until_ready(Client& client, Clock::time_point deadline, Readiness& readiness) {
  if (!client.send({{"op", "watch"}, {"classes", {"DEVICES", "HEALTH"}}})) return false;
  if (!client.send({{"op", "poll"}})) return false;
  while (Clock::now() < deadline) {
    const auto remaining = std::chrono::ceil<std::chrono::seconds>(deadline - Clock::now());
    const auto message = client.next(remaining);
    if (!message || !*message) return false;
    readiness.update(**message);
    if (readiness.delivering && readiness.healthy) return true;
  }
  return false;
}

}  // namespace

std::optional<std::string> wait_until_ready(const std::string& socket, double timeout_s,
                                            const std::string& config_digest) {
  const Clock::time_point deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                                        std::chrono::duration<double>(timeout_s));
  Readiness readiness;
  do {
    readiness = {};
    auto client = Client::connect(socket);
    if (client && !config_digest.empty() &&
        text_of(client->version(), "config_digest") != config_digest) {
      readiness.missing = "the daemon with configuration " + config_digest;
      client = fail("the daemon has another configuration");
    }
    if (client && reads_until_ready(*client, deadline, readiness)) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  } while (Clock::now() < deadline);
  return readiness.waiting_for();
}

}  // namespace infuse::daemon
