// The state of the daemon by what it reported last.

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

constexpr int64_t kNow = 1'795'230'810'120'000'000;  // 2026-11-21T03:13:30.120Z

Json health_report(const char* level, const Json& drift_findings = Json::array()) {
  return {
      {"class", "HEALTH"},
      {"stamp", kNow},
      {"drive_s", 36.2},
      {"level", level},
      {"streams",
       {{{"device", "front"},
         {"level", "OK"},
         {"received_hz", 10.0},
         {"used", 362},
         {"findings", Json::array()}}}},
      {"calibrations", {{{"device", "front"}, {"level", level}, {"findings", drift_findings}}}}};
}

Json drift_finding(const char* id, const char* level) {
  return {{"id", id},
          {"level", level},
          {"since", 1'795'230'775'000'000'000},
          {"what", "calibration drift confirmed: rotation about y"},
          {"advice", "drive on"}};
}

TEST(Status, ADriftIsShownWithTheLevelOfHealth) {
  const Json finding = drift_finding("drift_confirmed", "ERROR");
  const DaemonStatus status = daemon_status({health_report("ERROR", Json::array({finding}))});
  EXPECT_EQ(status.level, Level::kError);
  EXPECT_THAT(status.text, HasSubstr("03:13:30.120 HEALTH ERROR (running for 36 s)\n"));
  EXPECT_THAT(status.text, HasSubstr("  OK    front: 10.0/s, 362 used, 0 rejected\n"));
  EXPECT_THAT(status.text,
              HasSubstr("  ERROR calibration of front\n        calibration drift confirmed: "
                        "rotation about y, since 2026-11-21T03:12:55Z (drive on)\n"));
}

TEST(Status, ACalibrationWithoutImagesIsNotMonitored) {
  Json health = health_report("ERROR");
  health["calibrations"][0]["level"] = "OK";
  EXPECT_THAT(daemon_status({health}).text, HasSubstr("  OK    calibration of front\n"));
  for (const char* id : {"silent", "unavailable"}) {
    health["streams"][0]["findings"] = {drift_finding(id, "ERROR")};
    EXPECT_THAT(daemon_status({health}).text,
                HasSubstr("  -     calibration of front: not monitored, no images\n"));
  }
  health["calibrations"][0]["level"] = "ERROR";
  EXPECT_THAT(daemon_status({health}).text,
              HasSubstr("  ERROR calibration of front: not monitored, no images\n"));
}

TEST(Status, ARunningRecordingIsShown) {
  const Json record = {{"class", "RECORD"}, {"state", "recording"}, {"name", "evening"}};
  const DaemonStatus status = daemon_status({record, health_report("OK")});
  EXPECT_EQ(status.level, Level::kOk);
  EXPECT_THAT(status.text, HasSubstr("evening recording"));
  EXPECT_THAT(status.text, HasSubstr("HEALTH OK "));
}

TEST(Status, FindingsOfCalibrationsAreNamedByTheirCamera) {
  const Json finding = drift_finding("drift_confirmed", "ERROR");
  const auto findings = findings_of(health_report("ERROR", Json::array({finding})));
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].device, "front");
  EXPECT_TRUE(findings[0].of_calibration);
  EXPECT_EQ(text_of(findings[0].finding, "id"), "drift_confirmed");
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
                   Stamp::from_ns(kNow), report.dump());
  }
  std::thread thread([&] { io.run(); });
  ProgramResult result = run_shell_command(programs_folder() + "/infuse status --socket " + path);
  boost::asio::post(io, [&] { server.finish(std::chrono::milliseconds(100)); });
  thread.join();
  return result;
}

TEST(Status, TheExitStatusIsThatOfTheWorstLevel) {
  const ProgramResult drifted = status_of(
      {{ReportClass::kHealth,
        health_report("ERROR", Json::array({drift_finding("drift_confirmed", "ERROR")}))}});
  EXPECT_EQ(drifted.code, 1);
  EXPECT_THAT(drifted.output, HasSubstr("HEALTH ERROR "));
  EXPECT_THAT(drifted.output, HasSubstr("calibration drift confirmed"));
  const ProgramResult suspected =
      status_of({{ReportClass::kHealth,
                  health_report("WARN", Json::array({drift_finding("drift_suspected", "WARN")}))}});
  EXPECT_EQ(suspected.code, 0);
  EXPECT_THAT(suspected.output, HasSubstr("HEALTH WARN "));
}

}  // namespace
}  // namespace infuse::daemon
