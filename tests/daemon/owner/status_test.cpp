// The state of the daemon by what it reported last: HEALTH, and what HEALTH leaves out.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/post.hpp>
#include <future>
#include <thread>

#include "daemon/owner/report_text.hpp"
#include "daemon/server/server.hpp"
#include "tests/daemon/pipeline/run_replay.hpp"
#include "tests/daemon/run_program.hpp"
#include "tests/folders.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr int64_t kRaised = 1'795'230'775'000'000'000;  // 2026-11-21T03:12:55Z

Json health_report(const char* level, const Json& front_findings = Json::array()) {
  return {{"class", "HEALTH"},
          {"stamp", kRaised + 35'120'000'000},
          {"drive_s", 36.2},
          {"level", level},
          {"streams",
           {{{"device", "front"},
             {"level", level},
             {"received_hz", 10.0},
             {"used", 362},
             {"findings", front_findings}}}}};
}

Json alert_of_front(const char* id, const char* severity, const char* state) {
  return {{"class", "ALERT"},
          {"device", "front"},
          {"id", std::string("front.") + id},
          {"severity", severity},
          {"state", state},
          {"since", kRaised},
          {"what", "calibration drift confirmed: rotation about y"},
          {"advice", "drive on"}};
}

Json calibration_report() {
  return {{"class", "CALIBRATION"}, {"device", "front"}, {"state", "OK"}};
}

/// The state of a daemon that is well but for a confirmed drift, whose alert has this state.
DaemonStatus drift_status(const char* alert_state) {
  return daemon_status({calibration_report(),
                        alert_of_front("drift_confirmed", "ERROR", alert_state),
                        health_report("OK")});
}

TEST(Status, ARaisedDriftAlertIsShownAndCounts) {
  const DaemonStatus status = drift_status("raised");
  EXPECT_EQ(status.level, Level::kError);
  EXPECT_THAT(status.text, HasSubstr("03:13:30.120 HEALTH ERROR (running for 36 s)\n"));
  EXPECT_THAT(status.text, HasSubstr("  OK    front: 10.0/s, 362 used, 0 rejected\n"));
  EXPECT_THAT(status.text, HasSubstr("  ERROR front: calibration drift confirmed: rotation about "
                                     "y, since 2026-11-21T03:12:55Z (drive on)\n"));
}

TEST(Status, AClearedAlertDoesNotCount) {
  const DaemonStatus status = drift_status("cleared");
  EXPECT_EQ(status.level, Level::kOk);
  EXPECT_THAT(status.text, HasSubstr("HEALTH OK "));
  EXPECT_THAT(status.text, Not(HasSubstr("drift")));
}

TEST(Status, AFindingOfHealthIsShownOnce) {
  const Json finding = {{"id", "silent"},
                        {"level", "STALE"},
                        {"what", "no data from /dev/video0 for 3.0 s"},
                        {"advice", "check power and connection"}};
  const DaemonStatus status =
      daemon_status({calibration_report(), alert_of_front("silent", "STALE", "raised"),
                     alert_of_front("drift_suspected", "WARN", "raised"),
                     health_report("STALE", Json::array({finding}))});
  EXPECT_EQ(status.level, Level::kStale);
  EXPECT_THAT(status.text, HasSubstr("HEALTH STALE "));
  EXPECT_THAT(status.text, HasSubstr("        no data from /dev/video0 for 3.0 s (check power"));
  EXPECT_THAT(status.text, HasSubstr("  WARN  front: calibration drift"));
  EXPECT_THAT(status.text, Not(HasSubstr("  STALE front: calibration drift")));
}

TEST(Status, WithoutHealthThereIsNoLevel) {
  const DaemonStatus status = daemon_status({});
  EXPECT_EQ(status.level, Level::kOk);
  EXPECT_EQ(status.text, "no health report yet\n");
}

/// Runs `infuse status` while a server answers with these reports.
ProgramResult status_of(const std::vector<std::pair<ReportClass, Json>>& reports) {
  const TemporaryFolder folder;
  const std::string path = (folder / "s").string();
  boost::asio::io_context io;
  Server server(io, {}, "0.1.0", "0123456789abcdef");
  EXPECT_TRUE(server.listen(path));
  for (const auto& [report_class, report] : reports) {
    server.publish(report_class, report.value("id", report.value("device", "")),
                   Stamp::from_ns(kRaised), report.dump());
  }
  std::thread thread([&] { io.run(); });
  ProgramResult result = run_shell_command(programs_folder() + "/infuse status --socket " + path);
  boost::asio::post(io, [&] { server.finish(std::chrono::milliseconds(100)); });
  thread.join();
  return result;
}

TEST(Status, TheExitStatusIsThatOfTheWorstLevel) {
  const ProgramResult drifted =
      status_of({{ReportClass::kCalibration, calibration_report()},
                 {ReportClass::kAlert, alert_of_front("drift_confirmed", "ERROR", "raised")},
                 {ReportClass::kHealth, health_report("OK")}});
  EXPECT_EQ(drifted.code, 1);
  EXPECT_THAT(drifted.output, HasSubstr("HEALTH ERROR "));
  EXPECT_THAT(drifted.output, HasSubstr("calibration drift confirmed"));
  const ProgramResult suspected =
      status_of({{ReportClass::kCalibration, calibration_report()},
                 {ReportClass::kAlert, alert_of_front("drift_suspected", "WARN", "raised")},
                 {ReportClass::kHealth, health_report("OK")}});
  EXPECT_EQ(suspected.code, 0);
  EXPECT_THAT(suspected.output, HasSubstr("HEALTH WARN "));
}

}  // namespace
}  // namespace infuse::daemon
