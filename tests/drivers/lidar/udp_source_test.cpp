#include "drivers/lidar/udp_source.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>

#include <vector>

namespace infuse::lidar {
namespace {

constexpr size_t kMaxDatagramBytes = 2048;

using host::FileDescriptor;
using host::MessageBatch;
using host::TimeBase;

constexpr uint32_t kLoopback = 0x7F00'0001;
constexpr uint32_t kMulticastGroup = 0xEFFF'2A01;  // 239.255.42.1

/// A socket that sends from an address of the loopback network.
FileDescriptor open_sender(uint32_t address) {
  FileDescriptor sender(socket(AF_INET, SOCK_DGRAM, 0));
  sockaddr_in local{};
  local.sin_family = AF_INET;
  local.sin_addr.s_addr = htonl(address);
  EXPECT_EQ(bind(sender.get(), reinterpret_cast<sockaddr*>(&local), sizeof(local)), 0);
  const in_addr interface { htonl(kLoopback) };
  setsockopt(sender.get(), IPPROTO_IP, IP_MULTICAST_IF, &interface, sizeof(interface));
  return sender;
}

void send_to(const FileDescriptor& sender, uint16_t port, const std::vector<uint8_t>& payload,
             uint32_t receiver = kLoopback) {
  sockaddr_in remote{};
  remote.sin_family = AF_INET;
  remote.sin_port = htons(port);
  remote.sin_addr.s_addr = htonl(receiver);
  EXPECT_EQ(sendto(sender.get(), payload.data(), payload.size(), 0,
                   reinterpret_cast<sockaddr*>(&remote), sizeof(remote)),
            static_cast<ssize_t>(payload.size()));
}

/// A source on a free port of the loopback.
UdpSource open_source(const TimeBase& base, size_t buffer = 1 << 20) {
  auto source =
      UdpSource::open({.address = "127.0.0.1", .port = 0, .receive_buffer = buffer}, base);
  EXPECT_TRUE(source.has_value()) << source.error().message();
  return *std::move(source);
}

TEST(UdpSource, DeliversDatagramsWithSenderAndKernelStamp) {
  const TimeBase base;
  UdpSource source = open_source(base);
  MessageBatch batch(64, kMaxDatagramBytes);
  const FileDescriptor first = open_sender(kLoopback), second = open_sender(kLoopback + 1);
  const Stamp before = base.now();
  send_to(first, source.port(), std::vector<uint8_t>(1206, 7));
  send_to(second, source.port(), std::vector<uint8_t>(512, 9));
  const Stamp after = base.now();

  std::vector<uint32_t> senders;
  std::vector<size_t> sizes;
  std::vector<Stamp> stamps;
  const auto count = source.read(batch, [&](const Datagram& datagram) {
    senders.push_back(datagram.sender);
    sizes.push_back(datagram.payload.size());
    stamps.push_back(datagram.stamp);
    EXPECT_EQ(datagram.destination_port, source.port());
    EXPECT_EQ(datagram.payload.front(), datagram.payload.size() == 512 ? 9 : 7);
  });
  ASSERT_TRUE(count.has_value());
  EXPECT_EQ(*count, 2U);
  EXPECT_EQ(senders, (std::vector<uint32_t>{kLoopback, kLoopback + 1}));
  EXPECT_EQ(sizes, (std::vector<size_t>{1206, 512}));
  constexpr Duration kTolerance{1'000'000};  // two clocks are read one after the other
  EXPECT_GE(stamps[0], before - kTolerance);
  EXPECT_LE(stamps[0], stamps[1]);
  EXPECT_LE(stamps[1], after + kTolerance);
  EXPECT_FALSE(source.stamped_by_hardware()) << "the loopback makes no stamps";
  EXPECT_EQ(*source.read(batch, [](const Datagram&) {}), 0U);
}

TEST(UdpSource, ReadsAtMostABatch) {
  const TimeBase base;
  UdpSource source = open_source(base);
  MessageBatch batch(8, kMaxDatagramBytes);
  const FileDescriptor sender = open_sender(kLoopback);
  for (int i = 0; i < 20; ++i) send_to(sender, source.port(), {uint8_t(i)});
  std::vector<size_t> reads;
  std::vector<int> order;
  while (const auto count = source.read(
             batch, [&](const Datagram& datagram) { order.push_back(datagram.payload[0]); })) {
    if (*count == 0) break;
    reads.push_back(*count);
  }
  EXPECT_EQ(reads, (std::vector<size_t>{8, 8, 4}));
  ASSERT_EQ(order.size(), 20U);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(order[static_cast<size_t>(i)], i);
}

TEST(UdpSource, CountsDatagramsDroppedByTheKernel) {
  const TimeBase base;
  UdpSource source = open_source(base, 16 << 10);
  EXPECT_EQ(source.buffer_granted(), size_t{16} << 10);
  MessageBatch batch(64, kMaxDatagramBytes);
  const FileDescriptor sender = open_sender(kLoopback);
  constexpr uint64_t kSent = 200;
  for (uint64_t i = 0; i < kSent; ++i) send_to(sender, source.port(), std::vector<uint8_t>(1206));
  uint64_t received = 0;
  const auto read_all = [&] {
    while (*source.read(batch, [&](const Datagram&) { ++received; }) > 0) {
    }
  };
  read_all();
  EXPECT_LT(received, kSent);
  send_to(sender, source.port(), {1});  // carries the drop count
  read_all();
  EXPECT_EQ(source.dropped() + received, kSent + 1);
}

// The buffer has room for some of the true datagrams only, and for none beside the flood.
TEST(UdpSource, AFloodOfOtherSendersDisplacesNothing) {
  const TimeBase base;
  auto source = UdpSource::open({.address = "127.0.0.1",
                                 .port = 0,
                                 .receive_buffer = size_t{64} << 10,
                                 .senders = {kLoopback + 7, kLoopback}},
                                base);
  ASSERT_TRUE(source.has_value()) << source.error().message();
  EXPECT_TRUE(source->filters_senders());
  MessageBatch batch(64, kMaxDatagramBytes);
  const FileDescriptor sensor = open_sender(kLoopback), other = open_sender(kLoopback + 1);
  uint64_t from_sensor = 0, from_others = 0;
  for (int i = 0; i < 100; ++i) {
    for (int k = 0; k < 64; ++k) send_to(other, source->port(), std::vector<uint8_t>(1206));
    send_to(sensor, source->port(), std::vector<uint8_t>(1206));
    if (i % 4 != 3) continue;
    while (*source->read(batch, [&](const Datagram& datagram) {
      (datagram.sender == kLoopback ? from_sensor : from_others) += 1;
    }) > 0) {
    }
  }
  EXPECT_EQ(from_sensor, 100U);
  EXPECT_LT(from_others, 200U);      // 25 of 6400 are expected to pass
  EXPECT_EQ(source->dropped(), 0U);  // what the filter rejects is not lost
}

TEST(UdpSource, ReportsABufferSmallerThanRequested) {
  const TimeBase base;
  const UdpSource source = open_source(base, size_t{1} << 30);
  EXPECT_LT(source.buffer_granted(), source.buffer_requested());
  EXPECT_GT(source.buffer_granted(), 0U);
}

TEST(UdpSource, TruncatesALongDatagramAndContinues) {
  const TimeBase base;
  UdpSource source = open_source(base);
  MessageBatch batch(64, kMaxDatagramBytes);
  const FileDescriptor sender = open_sender(kLoopback);
  send_to(sender, source.port(), std::vector<uint8_t>(5000));
  send_to(sender, source.port(), {});
  std::vector<size_t> sizes;
  ASSERT_TRUE(source.read(batch, [&](const Datagram& d) { sizes.push_back(d.payload.size()); }));
  EXPECT_EQ(sizes, (std::vector<size_t>{kMaxDatagramBytes, 0}));
}

TEST(UdpSource, ReceivesFromAJoinedMulticastGroup) {
  const TimeBase base;
  auto source = UdpSource::open({.address = "239.255.42.1",
                                 .port = 0,
                                 .multicast = "239.255.42.1",
                                 .interface = "lo",
                                 .receive_buffer = 1 << 16},
                                base);
  ASSERT_TRUE(source.has_value()) << source.error().message();
  source->rejoin();  // existing membership is not a failure
  MessageBatch batch(4, kMaxDatagramBytes);
  send_to(open_sender(kLoopback), source->port(), {1, 2, 3}, kMulticastGroup);
  size_t bytes = 0;
  ASSERT_TRUE(source->read(batch, [&](const Datagram& d) { bytes += d.payload.size(); }));
  EXPECT_EQ(bytes, 3U);
}

TEST(UdpSource, ReportsWhyAPortCannotBeOpened) {
  const TimeBase base;
  const UdpSource source = open_source(base);
  const auto taken = UdpSource::open({.address = "127.0.0.1", .port = source.port()}, base);
  ASSERT_FALSE(taken.has_value());
  EXPECT_NE(taken.error().message().find("the port is in use by another program"),
            std::string::npos);
  EXPECT_FALSE(UdpSource::open({.address = "192.0.2.77", .port = 0}, base).has_value());
  EXPECT_FALSE(UdpSource::open({.port = 0, .multicast = "239.1.1.1", .interface = "nosuch0"}, base)
                   .has_value());
}

TEST(UdpOptions, RejectInvalidValues) {
  EXPECT_FALSE(UdpOptions{}.invalid());
  EXPECT_TRUE(UdpOptions{.address = "lidar"}.invalid());
  EXPECT_TRUE(UdpOptions{.multicast = "10.0.0.1"}.invalid());
  EXPECT_TRUE(UdpOptions{.interface = "a-name-that-is-too-long"}.invalid());
  EXPECT_TRUE(UdpOptions{.receive_buffer = 0}.invalid());
}

}  // namespace
}  // namespace infuse::lidar
