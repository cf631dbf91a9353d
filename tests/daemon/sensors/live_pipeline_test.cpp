#include "daemon/sensors/live_pipeline.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "daemon/setup/live_setup.hpp"
#include "tests/daemon/sensors/loopback.hpp"

namespace infuse::daemon {
namespace {

/// A lidar on the loopback, and a missing camera and CAN bus.
SensorSetup loopback_setup() {
  Config config = loopback_config();
  config.cameras.emplace_back().stream.device = "/dev/no-such-camera";
  config.buses.emplace_back().interface = "nosuchcan0";
  config.gnss.lidar = config.lidars[0].name;
  auto setup = set_up_live(config);
  EXPECT_TRUE(setup.has_value());
  return *std::move(setup);
}

TEST(LivePipeline, ProcessesALidarAndReportsMissingSources) {
  boost::asio::io_context io(1);
  Server server(io, {}, "0.1.0", "0123456789abcdef");
  bool ended = false;
  LivePipeline live(io, loopback_setup(), {}, server, [&] {
    ended = true;
    server.finish(std::chrono::milliseconds(0));
  });
  int ticks = 0;
  std::atomic<uint64_t> sent = 0;  // 0: not sent yet
  std::thread sender;
  live.publisher().set_progress_listener([&] {
    if (ticks++ == 0) sender = std::thread([&] { sent = send_capture(test_port(0)); });
    const uint64_t packets = live.publisher().totals().counters.lidars[0].packets;
    if (sent > 0 && (packets >= sent || ticks > 20)) live.stop();
  });
  live.start();
  io.run_for(std::chrono::seconds(60));
  sender.join();
  ASSERT_TRUE(ended);
  const Totals& totals = live.publisher().totals();
  const LidarCounters& lidar = totals.counters.lidars[0];
  EXPECT_EQ(lidar.packets + lidar.lost_kernel, sent.load());
  EXPECT_GE(lidar.sweeps, 8U);
  EXPECT_GT(lidar.position_packets, 0U);
  EXPECT_TRUE(lidar.source.open);
  for (const StreamCounters& gone : {totals.counters.cameras.at(0), totals.counters.buses.at(0)}) {
    EXPECT_FALSE(gone.source.open);
    EXPECT_NE(gone.source.problem[0], '\0');
  }
  // Every sentence of the position packets gives one fix.
  EXPECT_TRUE(totals.counters.gnss.source.open);
  EXPECT_GT(totals.counters.gnss.received, 0U);
  EXPECT_LE(totals.counters.gnss.received, lidar.position_packets);
  EXPECT_EQ(totals.levels.lidars[0] == Level::kStale, false);
  EXPECT_NE(totals.levels.cameras[0], Level::kOk);
}

TEST(LivePipeline, EndsAtOnceWithoutSensorData) {
  boost::asio::io_context io(1);
  Server server(io, {}, "0.1.0", "0123456789abcdef");
  bool ended = false;
  LivePipeline live(io, loopback_setup(), {}, server, [&] {
    ended = true;
    server.finish(std::chrono::milliseconds(0));
  });
  live.publisher().set_progress_listener([&] { live.stop(); });
  live.start();
  io.run_for(std::chrono::seconds(30));
  EXPECT_TRUE(ended);
}

}  // namespace
}  // namespace infuse::daemon
