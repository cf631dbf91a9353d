#include "daemon/sensors/recording_controller.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "daemon/sensors/live_pipeline.hpp"
#include "daemon/setup/live_setup.hpp"
#include "tests/daemon/pipeline/run_replay.hpp"
#include "tests/daemon/sensors/loopback.hpp"
#include "tests/daemon/socket_client.hpp"
#include "tests/faults/disk_fault.hpp"

namespace infuse::daemon {
namespace {

using nlohmann::json;

/// SWEEP reports by stamp, without their sequence number.
std::map<int64_t, json> parse_sweeps(const std::vector<std::string>& lines) {
  std::map<int64_t, json> sweeps;
  for (const std::string& line : lines) {
    json report = json::parse(line);
    if (report["class"] != "SWEEP") continue;
    report.erase("sequence");
    const auto stamp = report["stamp"].get<int64_t>();
    sweeps[stamp] = std::move(report);
  }
  return sweeps;
}

class RecordingControllerTest : public testing::Test {
 protected:
  RecordingControllerTest() {
    config_ = loopback_config();
    // A late sweep is not registered: what follows from it depends on the processor.
    config_.odometry.use_lidar = false;
    config_.record.directory = (folder_ / "drives").string();
    config_.record.min_free = 0;
    config_.record.memory = 16 << 20;
    config_.health.clock_grace = from_seconds(1e6);
  }

  /// Replays a recording with the settings of the daemon that made it.
  auto replay(const std::filesystem::path& drive) const {
    RunReplayOptions options;
    options.pipeline.odometry = config_.odometry;
    return run_replay(drive, options);
  }

  /// Runs the daemon while a capture is sent to it. Calls `begin` at the first tick and `done` at
  /// every tick after the last packet, until it returns true.
  void run(const std::function<void(RecordingController&)>& begin,
           const std::function<bool(RecordingController&)>& done) {
    boost::asio::io_context io(1);
    Server server(io, {.queue_reports = 4096}, "0.1.0", "0123456789abcdef");
    ASSERT_TRUE(server.listen(folder_ / "s"));
    auto setup = set_up_live(config_);
    ASSERT_TRUE(setup);
    const host::TimeBase base;
    RecordingController controller(config_, *setup, [base] { return base.now(); });
    LivePipeline live(
        io, *std::move(setup), {config_.health, config_.odometry}, server,
        [&] {
          controller.finish();
          server.finish(std::chrono::seconds(2));
        },
        base, controller.tap());
    controller.set_publisher(live.publisher());
    std::thread listener([&] {
      SocketClient client(folder_ / "s");
      client.read_line();
      client.send("{\"op\":\"watch\"}\n");
      while (const auto line = client.read_line()) lines_.push_back(*line);
    });
    std::atomic<bool> sent = false;
    std::thread sender;
    int ticks = 0;
    live.publisher().set_progress_listener([&] {
      controller.publish_updates();
      if (++ticks == 2) {
        begin(controller);
        sender = std::thread([&] {
          send_capture(test_port(0));
          sent = true;
        });
      }
      if ((sent && done(controller)) || ticks > 40) live.stop();
    });
    live.start();
    io.run_for(std::chrono::seconds(90));
    sender.join();
    listener.join();
  }

  json last_record() const {
    json last;
    for (const std::string& line : lines_) {
      json report = json::parse(line);
      if (report["class"] == "RECORD") last = std::move(report);
    }
    return last;
  }

  TemporaryFolder folder_;
  Config config_;
  std::vector<std::string> lines_;
};

TEST_F(RecordingControllerTest, ARecordingReplaysToTheSameSweeps) {
  run(
      [](RecordingController& controller) {
        EXPECT_TRUE(controller.handle_request({.op = Request::Op::kRecord, .name = "street"}));
        EXPECT_FALSE(controller.handle_request({.op = Request::Op::kRecord, .name = "another"}));
      },
      [stop_requested = false](RecordingController& controller) mutable {
        if (std::exchange(stop_requested, true)) return true;
        EXPECT_TRUE(controller.handle_request({.op = Request::Op::kRecord, .on = false}));
        return false;
      });
  const json record = last_record();
  EXPECT_EQ(record["state"], "ended");
  EXPECT_EQ(record["lost"], 0);
  EXPECT_GT(record["datagrams"], 700);
  const auto again = replay(folder_ / "drives" / "street");
  ASSERT_TRUE(again) << again.error().message();
  const auto live = parse_sweeps(lines_), replayed = parse_sweeps(again->lines());
  EXPECT_GE(live.size(), 8U);
  EXPECT_EQ(live, replayed);
}

TEST_F(RecordingControllerTest, TheEndOfARecordingIsReportedBeforeTheNextBegins) {
  run(
      [](RecordingController& controller) {
        EXPECT_TRUE(controller.handle_request(
            {.op = Request::Op::kRecord, .name = "one", .max_duration = from_seconds(0.3)}));
        for (int i = 0; i < 3000 && controller.is_recording(); ++i) {
          std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
        EXPECT_TRUE(controller.handle_request({.op = Request::Op::kRecord, .name = "two"}));
      },
      [](RecordingController&) { return true; });
  std::vector<std::string> reports;
  for (const std::string& line : lines_) {
    const json report = json::parse(line);
    if (report["class"] != "RECORD") continue;
    reports.push_back(report["name"].get<std::string>() + " " + report["state"].get<std::string>());
  }
  EXPECT_THAT(reports, testing::Contains("one ended"));
  EXPECT_EQ(last_record()["name"], "two");
}

TEST_F(RecordingControllerTest, AnAlertIsRecordedWithTheDataBeforeIt) {
  config_.record.flight_recorder = from_seconds(60);
  config_.record.after_alert = from_seconds(1);
  ::setenv("STATE_DIRECTORY", (folder_ / "").c_str(), 1);
  std::filesystem::create_directory(folder_ / "spool");
  // The lidar goes silent after the capture, which raises an alert.
  run([](RecordingController&) {},
      [begun = false, ticks = 0](RecordingController& controller) mutable {
        begun = begun || controller.is_recording();
        return begun && !controller.is_recording() && ++ticks > 1;
      });
  ::unsetenv("STATE_DIRECTORY");
  const json record = last_record();
  ASSERT_EQ(record["state"], "ended");
  std::string spooled;
  std::getline(std::ifstream(folder_ / "spool" / record["name"].get<std::string>()), spooled);
  EXPECT_EQ(spooled, record["folder"]);
  EXPECT_EQ(record["cause"].get<std::string>().substr(0, 6), "lidar.");
  EXPECT_GT(record["datagrams"], 700);
  const auto again = replay(record["folder"].get<std::string>());
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_GE(parse_sweeps(again->lines()).size(), 8U);
}

// It is found when the next recording begins, and stays raised.
TEST_F(RecordingControllerTest, ASpoolOnAFullDiskIsSaidAndTheRecordingStays) {
  config_.record.flight_recorder = from_seconds(60);
  config_.record.after_alert = from_seconds(0.1);
  ::setenv("STATE_DIRECTORY", (folder_ / "").c_str(), 1);
  std::filesystem::create_directory(folder_ / "spool");
  const DiskFault fault(folder_ / "spool", ENOSPC);
  run([](RecordingController&) {},
      [begun = false, ticks = 0](RecordingController& controller) mutable {
        if (begun) return ++ticks > 1;
        if (!controller.is_recording()) return false;
        for (int wait = 0; wait < 500 && controller.is_recording(); ++wait) {
          std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
        begun = true;
        EXPECT_TRUE(controller.handle_request({.op = Request::Op::kRecord, .name = "next"}));
        return false;
      });
  ::unsetenv("STATE_DIRECTORY");
  std::vector<json> alerts;
  for (const std::string& line : lines_) {
    json report = json::parse(line);
    if (report["class"] == "RECORD" && report["state"] == "ended" && report["name"] != "next") {
      EXPECT_TRUE(std::filesystem::exists(report["folder"].get<std::string>() + "/drive.toml"));
    }
    if (report["class"] == "ALERT" && report.dump().find("record") != std::string::npos &&
        report["device"] == kDaemonDevice) {
      alerts.push_back(std::move(report));
    }
  }
  EXPECT_EQ(last_record()["name"], "next");
  ASSERT_EQ(alerts.size(), 1U);
  EXPECT_THAT(alerts[0].dump(),
              testing::AllOf(testing::HasSubstr("is not in the spool"),
                             testing::HasSubstr("No space left on device"),
                             testing::HasSubstr("on the disk of " + (folder_ / "spool").string())));
}

TEST_F(RecordingControllerTest, RefusesNamesThatLeaveTheFolder) {
  for (const char* name : {"", ".", "..", "../x", "a/b", "/tmp/x", "-x", "x.2", "alert-x", "ü"}) {
    EXPECT_FALSE(is_recording_name(name)) << name;
  }
  EXPECT_FALSE(is_recording_name(std::string(65, 'x')));
  EXPECT_FALSE(is_recording_name(std::string("x\0y", 3)));
  EXPECT_TRUE(is_recording_name("20261121-061136"));
  EXPECT_TRUE(is_recording_name("around_the-block7"));
}

}  // namespace
}  // namespace infuse::daemon
