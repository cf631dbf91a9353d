#include "daemon/live/live.hpp"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "drivers/recording/pcap_reader.hpp"
#include "fixtures/scene/capture.hpp"

namespace infuse::daemon {
namespace {

/// A port that is not this process's in another run of the tests.
uint16_t test_port(int which) {
  return static_cast<uint16_t>(20'000 + getpid() % 10'000 * 2 + which);
}

/// A lidar on the loopback, a camera and a bus that are not there.
LiveSetup loopback_setup() {
  Config config;
  LidarOptions& lidar = config.lidars.emplace_back();
  lidar.model = "VLP-16";
  lidar.address = "127.0.0.1";
  lidar.port = test_port(0);
  lidar.position_port = test_port(1);
  config.cameras.emplace_back().stream.device = "/dev/no-such-camera";
  config.buses.emplace_back().interface = "nosuchcan0";
  auto setup = set_up_live(config);
  EXPECT_TRUE(setup.has_value());
  return *std::move(setup);
}

/// Sends a second of a street to the lidar's port; the data packets that were sent.
uint64_t send_capture(uint16_t port) {
  const auto path =
      std::filesystem::path(testing::TempDir()) / ("infuse-live-" + std::to_string(getpid()));
  const auto made =
      fixtures::make_capture(path, {.model = velodyne::Model::kVlp16, .length = from_seconds(1)});
  EXPECT_TRUE(made.has_value());
  auto reader = recording::PcapReader::open(path);
  EXPECT_TRUE(reader.has_value());
  const receive::Descriptor socket(::socket(AF_INET, SOCK_DGRAM, 0));
  sockaddr_in receiver{};
  receiver.sin_family = AF_INET;
  receiver.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  uint64_t sent = 0;
  Datagram datagram;
  while (reader->next(datagram)) {
    const bool data = datagram.payload.size() == velodyne::kPacketSize;
    receiver.sin_port = htons(data ? port : static_cast<uint16_t>(port + 1));
    EXPECT_GT(sendto(socket.get(), datagram.payload.data(), datagram.payload.size(), 0,
                     reinterpret_cast<sockaddr*>(&receiver), sizeof(receiver)),
              0);
    sent += data ? 1 : 0;
    std::this_thread::sleep_for(std::chrono::microseconds(500));
  }
  std::filesystem::remove(path);
  return sent;
}

TEST(Live, WhatIsSentComesThroughThePipelineAndWhatIsGoneIsSaid) {
  boost::asio::io_context io(1);
  Server server(io, {}, "0.1.0", "0123456789abcdef");
  bool ended = false;
  Live live(io, loopback_setup(), {}, server, [&] {
    ended = true;
    server.finish(std::chrono::milliseconds(0));
  });
  int ticks = 0;
  std::atomic<uint64_t> sent = 0;  // 0: not yet
  std::thread sender;
  live.publisher().on_progress([&] {
    if (ticks++ == 0) sender = std::thread([&] { sent = send_capture(test_port(0)); });
    const uint64_t packets = live.publisher().totals().counters[0].packets;
    if (sent > 0 && (packets >= sent || ticks > 20)) live.stop();
  });
  live.start();
  io.run_for(std::chrono::seconds(60));
  sender.join();
  ASSERT_TRUE(ended);
  const Totals& totals = live.publisher().totals();
  const SensorCounters& lidar = totals.counters[0];
  EXPECT_EQ(lidar.packets + lidar.lost_kernel, sent.load());
  EXPECT_GE(lidar.sweeps, 8U);
  EXPECT_GT(lidar.position_packets, 0U);
  EXPECT_TRUE(lidar.source.open);
  ASSERT_EQ(totals.streams.size(), 2U);
  for (const StreamCounters& gone : totals.streams) {
    EXPECT_FALSE(gone.source.open);
    EXPECT_NE(gone.source.problem[0], '\0');
  }
  EXPECT_EQ(totals.levels[0] == Level::kStale, false);
  EXPECT_NE(totals.levels[1], Level::kOk);
}

TEST(Live, EndsAtOnceWhereNoSensorSaysAnything) {
  boost::asio::io_context io(1);
  Server server(io, {}, "0.1.0", "0123456789abcdef");
  bool ended = false;
  Live live(io, loopback_setup(), {}, server, [&] {
    ended = true;
    server.finish(std::chrono::milliseconds(0));
  });
  live.publisher().on_progress([&] { live.stop(); });
  live.start();
  io.run_for(std::chrono::seconds(30));
  EXPECT_TRUE(ended);
}

}  // namespace
}  // namespace infuse::daemon
