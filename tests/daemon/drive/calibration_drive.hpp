#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/daemon/drive/simulated.hpp"
#include "tests/daemon/schema.hpp"

namespace infuse::daemon {

/// Two pictures a second, the lidar turning around each of them (`turn_stride` 5) or all the time
/// (1). `more`: faults.
inline void make_online_drive(const std::filesystem::path& folder, double seconds, int turn_stride,
                              const std::string& more) {
  const std::string text = "duration_s = " + std::to_string(seconds) + R"(
[world]
map = "altfeld.osm"
route = [100, 104, 112, 110, 115, 117]
[light]
sun = 0.6
[vehicle]
speed = 9
start_speed = 9
[[lidar]]
model = "HDL-32E"
position = [1.0, 0.0, 1.95]
rays_per_pulse = 1
turn_stride = )" + std::to_string(turn_stride) +
                           R"(
[[camera]]
width = 480
height = 360
fx = 300
position = [1.5, 0.05, 1.6]
rotation_deg = [0.0, 2.0, 0.0]
rate_hz = 2
phase_s = 0.05
samples = 1
format = "jpg"
)" + more;
  const auto made = simulate(folder, text);
  ASSERT_TRUE(made) << made.error().message();
}

/// What a replay told of its one camera's calibration.
struct CalibrationHistory {
  std::vector<std::string> states;           ///< one after the other
  std::vector<std::string> faults;           ///< of the camera, the same
  std::vector<std::string> alerts;           ///< ids of those that were raised
  nlohmann::json first_report, last_report;  ///< CALIBRATION reports
};

inline CalibrationHistory read_calibration_history(const ReplayResult& replayed) {
  CalibrationHistory history;
  for (const std::string& line : replayed.lines()) {
    EXPECT_TRUE(is_valid_message(line));
    nlohmann::json report = nlohmann::json::parse(line);
    if (report["class"] == "ALERT" && report["state"] == "raised") {
      history.alerts.push_back(report["id"]);
    }
    if (report["class"] != "CALIBRATION") continue;
    history.states.push_back(report["state"]);
    if (report.contains("camera_fault")) history.faults.push_back(report["camera_fault"]);
    if (history.first_report.is_null()) history.first_report = report;
    history.last_report = std::move(report);
  }
  return history;
}

}  // namespace infuse::daemon
