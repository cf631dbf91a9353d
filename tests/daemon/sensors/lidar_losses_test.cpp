#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "daemon/pipeline/lidar_intake.hpp"
#include "drivers/recording/pcap_reader.hpp"
#include "drivers/velodyne/packet.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"
#include "fixtures/scene/capture.hpp"

namespace infuse::daemon {
namespace {

/// Counters after one second of a VLP-16 without the packets `from` … `to` − 1, of which the kernel
/// reports `by_kernel` as dropped, in addition to `positions` position packets.
LidarCounters counters_with_loss(uint64_t from, uint64_t to, uint64_t by_kernel,
                                 uint64_t positions = 0) {
  const auto path =
      std::filesystem::path(testing::TempDir()) / ("infuse-losses-" + std::to_string(getpid()));
  EXPECT_TRUE(fixtures::make_capture(
      path,
      {.model = &velodyne::lidar_model(velodyne::Model::kVlp16), .duration = from_seconds(1)}));
  auto reader = recording::PcapReader::open(path);
  std::filesystem::remove(path);
  EXPECT_TRUE(reader.has_value());
  LidarSetup setup;
  setup.decoder.model = &velodyne::lidar_model(velodyne::Model::kVlp16);
  LidarIntake intake(setup);
  intake.add_kernel_dropped(positions, false);
  uint64_t network_before = 0;
  Datagram datagram;
  for (uint64_t i = 0; reader->next(datagram);) {
    if (datagram.payload.size() != velodyne::kPacketSize) continue;
    const uint64_t number = i++;
    if (number >= from && number < to) continue;
    if (number == to) intake.add_kernel_dropped(by_kernel, true);
    intake.add_datagram(datagram, [](Sweep&) {});
    EXPECT_GE(intake.counters().lost_network, network_before);
    network_before = intake.counters().lost_network;
  }
  intake.finish([](Sweep&) {});
  return intake.counters();
}

TEST(LidarLosses, KernelDropsAreNotCountedAsNetworkLoss) {
  const LidarCounters counters = counters_with_loss(300, 350, 50);
  EXPECT_EQ(counters.lost_kernel, 50U);
  EXPECT_EQ(counters.lost_network, 0U);
}

TEST(LidarLosses, TheRemainderOfAGapIsNetworkLoss) {
  const LidarCounters counters = counters_with_loss(300, 350, 30);
  EXPECT_EQ(counters.lost_kernel, 30U);
  EXPECT_EQ(counters.lost_network, 20U);
}

TEST(LidarLosses, DroppedPositionPacketsDoNotHideNetworkLoss) {
  const LidarCounters counters = counters_with_loss(300, 350, 0, 7);
  EXPECT_EQ(counters.lost_kernel, 7U);
  EXPECT_EQ(counters.lost_network, 50U);
}

}  // namespace
}  // namespace infuse::daemon
