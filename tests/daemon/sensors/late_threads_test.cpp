// Each thread of the live daemon, late at its start.

#include <dlfcn.h>
#include <gmock/gmock.h>
#include <pthread.h>

#include <atomic>
#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "daemon/pipeline/pipeline.hpp"
#include "daemon/record/recorder.hpp"
#include "tests/daemon/pipeline/run_replay.hpp"
#include "tests/stamp_at.hpp"

namespace infuse::daemon {
namespace {

constexpr std::chrono::milliseconds kLate{1500};

std::atomic<const char*> late_thread = "";  // by name
std::atomic<int> late_starts = 0;

}  // namespace
}  // namespace infuse::daemon

/// Every thread of the daemon names itself before it does anything else.
extern "C" int pthread_setname_np(pthread_t thread, const char* name) noexcept {
  using namespace infuse::daemon;
  if (std::strcmp(name, late_thread) == 0) {
    std::this_thread::sleep_for(kLate);
    ++late_starts;
  }
  static const auto real =
      reinterpret_cast<int (*)(pthread_t, const char*)>(dlsym(RTLD_NEXT, "pthread_setname_np"));
  return real(thread, name);
}

namespace infuse::daemon {
namespace {

using testing::ElementsAre;

constexpr double kDriveSeconds = 4;
constexpr int kEventsPerSecond = 100;
constexpr std::chrono::milliseconds kEventPeriod{5};  // twice as fast as the drive

/// A lidar, a camera and an inertial unit of this host.
SensorSetup live_setup() {
  SensorSetup setup;
  setup.live = true;
  setup.lidars.push_back({.device = {.name = "top", .kind = "lidar"}, .has_packets = false});
  setup.cameras.push_back({.device = {.name = "front", .kind = "camera"}});
  setup.vehicle.imu = Device{.name = "imu", .kind = "imu"};
  setup.rig.lidars.push_back({.name = "top"});
  CameraMount& camera = setup.rig.cameras.emplace_back();
  camera.name = "front";
  camera.lidar = "top";
  camera.intrinsics.width = camera.intrinsics.height = 8;
  camera.intrinsics.fx = camera.intrinsics.fy = 4;
  return setup;
}

/// What the io thread reads: more than the rings hold while a thread is late.
void feed(Intake& intake, RecordTap& tap) {
  const std::vector<uint8_t> bytes(64);
  Sweep sweep;
  sweep.resize(3);
  intake.start(at(0));
  for (int event = 0; event < kDriveSeconds * kEventsPerSecond; ++event) {
    const Stamp now = at(static_cast<double>(event) / kEventsPerSecond);
    intake.advance(now);
    intake.add_imu({now, {0, 0, 0}, {0, 0, 9.81}}, now);
    intake.push_due_samples(now);
    tap.add_datagram({now, 0x0A00'0001, 2368, 2368, bytes});
    tap.flush_if_due(now);
    if (event % 10 == 0) {
      sweep.stamp = now;
      intake.add_sweep(LidarIndex(0), sweep);
      const camera::RawImage raw{camera::RawFormat::kGrey, 8, 8, 8, bytes};
      intake.add_streamed_image(CameraIndex(0), {.stamp = now, .raw = raw});
    }
    std::this_thread::sleep_for(kEventPeriod);
  }
  intake.end(at(kDriveSeconds));
}

/// What a run published.
struct Published {
  std::vector<std::string> devices;  ///< DEVICES reports
  std::vector<Stamp> health;         ///< stamps of HEALTH
  uint64_t items_lost = 0;           ///< to fusion
};

Published run_with_late(const char* thread) {
  late_thread = thread;
  late_starts = 0;
  const TemporaryFolder folder;
  boost::asio::io_context io(1);
  Server server(io, {}, "0", "0123456789abcdef");
  Recorder recorder({.memory = 1 << 20, .flight_recorder = from_seconds(1)}, folder / "drives",
                    [] { return at(0); });
  const SensorSetup setup = live_setup();
  Pipeline pipeline(io, setup, {}, server, nullptr, [&] {
    recorder.finish();
    server.finish(std::chrono::milliseconds(0));
  });
  Published run;
  Publisher& publisher = pipeline.publisher();
  publisher.add_line_listener([&](ReportClass kind, const std::string&, const std::string& line) {
    if (kind == ReportClass::kDevices) run.devices.push_back(line);
  });
  publisher.add_health_listener([&](const HealthReport& health) {
    run.health.push_back(health.stamp);
    run.items_lost = health.host->queues.at(0).lost;
  });
  pipeline.start([&](std::stop_token) { feed(pipeline.intake(), recorder.tap()); });
  io.run();
  late_thread = "";
  return run;
}

class LateThread : public testing::TestWithParam<const char*> {};

TEST_P(LateThread, LosesDataButNoSecondOfHealth) {
  const Published run = run_with_late(GetParam());
  EXPECT_GE(late_starts, 1);  // a camera has two threads in the background
  EXPECT_THAT(run.health, ElementsAre(at(1), at(2), at(3), at(4)));
  ASSERT_FALSE(run.devices.empty());
  const auto first = nlohmann::json::parse(run.devices.front());
  EXPECT_EQ(first["stamp"], at(0).ns());
  EXPECT_EQ(first["devices"].size(), 3U);
  if (std::strcmp(GetParam(), "fusion") == 0) {
    EXPECT_GT(run.items_lost, 0U);
  }
}

INSTANTIATE_TEST_SUITE_P(Each, LateThread,
                         testing::Values("fusion", "images", "background", "record"),
                         [](const auto& thread) { return std::string(thread.param); });

}  // namespace
}  // namespace infuse::daemon
