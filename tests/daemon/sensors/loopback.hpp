#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include "daemon/setup/live_setup.hpp"
#include "drivers/host/file_descriptor.hpp"
#include "drivers/recording/pcap_reader.hpp"
#include "drivers/velodyne/packet.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"
#include "fixtures/scene/capture.hpp"

namespace infuse::daemon {

/// A UDP port that depends on the process, so that concurrent test runs do not collide.
inline uint16_t test_port(int which) {
  return static_cast<uint16_t>(20'000 + getpid() % 10'000 * 2 + which);
}

/// Configuration of one lidar on the loopback.
inline Config loopback_config() {
  Config config;
  LidarOptions& lidar = config.lidars.emplace_back();
  lidar.model = "VLP-16";
  lidar.address = "127.0.0.1";
  lidar.port = test_port(0);
  lidar.position_port = test_port(1);
  return config;
}

/// Sends one second of a street scene to the lidar's ports. Returns the number of data packets.
inline uint64_t send_capture(uint16_t port) {
  const auto path =
      std::filesystem::path(testing::TempDir()) / ("infuse-live-" + std::to_string(getpid()));
  const auto made = fixtures::make_capture(
      path,
      {.model = &velodyne::lidar_model(velodyne::Model::kVlp16), .duration = from_seconds(1)});
  EXPECT_TRUE(made.has_value());
  auto reader = recording::PcapReader::open(path);
  EXPECT_TRUE(reader.has_value());
  const host::FileDescriptor socket(::socket(AF_INET, SOCK_DGRAM, 0));
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

}  // namespace infuse::daemon
