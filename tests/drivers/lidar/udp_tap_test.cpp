// Datagrams addressed to another host, from the loopback of a network namespace of their own.

#include "drivers/lidar/udp_tap.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <linux/if_packet.h>
#include <net/ethernet.h>
#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <thread>

#include "drivers/lidar/udp_source.hpp"

namespace infuse::lidar {
namespace {

using Bytes = std::vector<uint8_t>;

constexpr uint32_t kLidar = 0xC0A8'01C9;      // 192.168.1.201
constexpr uint32_t kOtherHost = 0xC0A8'0105;  // not an address of this namespace
constexpr uint8_t kUdp = 17, kTcp = 6;

void add_u16(Bytes& bytes, size_t value) {
  bytes.push_back(static_cast<uint8_t>(value >> 8));
  bytes.push_back(static_cast<uint8_t>(value));
}

struct Sent {
  uint16_t port = 2368;
  uint8_t protocol = kUdp;
  uint16_t fragment = 0;  ///< flags and offset of the IPv4 header
  size_t payload = 1206;
};

/// An IPv4 packet, RFC 791 and RFC 768.
Bytes make_packet(const Sent& sent) {
  Bytes bytes = {0x45, 0};
  add_u16(bytes, 28 + sent.payload);
  add_u16(bytes, 0);
  add_u16(bytes, sent.fragment);
  bytes.insert(bytes.end(), {64, sent.protocol, 0, 0});
  for (const uint32_t address : {kLidar, kOtherHost}) {
    add_u16(bytes, address >> 16);
    add_u16(bytes, address & 0xFFFF);
  }
  add_u16(bytes, 4321);
  add_u16(bytes, sent.port);
  add_u16(bytes, 8 + sent.payload);
  add_u16(bytes, 0);
  for (size_t i = 0; i < sent.payload; ++i) bytes.push_back(static_cast<uint8_t>(i * 7));
  return bytes;
}

/// The loopback of a new network namespace, for the calling thread.
class Wire {
 public:
  Wire() {
    if (unshare(CLONE_NEWNET) != 0) return;
    const host::FileDescriptor control(socket(AF_INET, SOCK_DGRAM, 0));
    ifreq request{};
    std::copy_n("lo", 3, request.ifr_name);
    request.ifr_flags = IFF_UP;
    ioctl(control.get(), SIOCSIFFLAGS, &request);
    socket_ = host::FileDescriptor(socket(AF_PACKET, SOCK_RAW, htons(ETH_P_IP)));
  }

  /// True if this process may make namespaces and packet sockets.
  bool usable() const { return static_cast<bool>(socket_); }

  /// Sends a frame to another station.
  void send(const Sent& sent) const {
    Bytes frame = {2, 0, 0, 0, 0, 9, 2, 0, 0, 0, 0, 1, 8, 0};
    const Bytes packet = make_packet(sent);
    frame.insert(frame.end(), packet.begin(), packet.end());
    sockaddr_ll to{};
    to.sll_family = AF_PACKET;
    to.sll_ifindex = static_cast<int>(if_nametoindex("lo"));
    EXPECT_EQ(sendto(socket_.get(), frame.data(), frame.size(), 0, reinterpret_cast<sockaddr*>(&to),
                     sizeof(to)),
              static_cast<ssize_t>(frame.size()));
  }

 private:
  host::FileDescriptor socket_;
};

/// Runs a test on a thread, the only one in the new namespace.
template <class Test>
void run_on_wire(Test test) {
  bool usable = false;
  std::thread([&] {
    const Wire wire;
    usable = wire.usable();
    if (usable) test(wire);
  }).join();
  if (!usable) GTEST_SKIP() << "network namespaces and packet sockets need root";
}

UdpSource open_tap_source(const host::TimeBase& base, size_t buffer = 1 << 20) {
  auto source = UdpSource::open({.interface = "lo", .tap = true, .receive_buffer = buffer}, base);
  EXPECT_TRUE(source) << source.error().message();
  return *std::move(source);
}

TEST(UdpTap, ReceivesWhatIsAddressedToAnotherHost) {
  run_on_wire([](const Wire& wire) {
    const host::TimeBase base;
    UdpSource tap = open_tap_source(base);
    auto socket = UdpSource::open({}, base);
    ASSERT_TRUE(socket);
    const Stamp before = base.now();
    wire.send({});
    wire.send({.port = 2369});
    wire.send({.protocol = kTcp});
    wire.send({.fragment = 0x2000});
    wire.send({.fragment = 100});
    wire.send({.payload = 0});
    host::MessageBatch batch(64, 2048);
    std::vector<size_t> sizes;
    const auto count = tap.read(batch, [&](const Datagram& datagram) {
      sizes.push_back(datagram.payload.size());
      EXPECT_EQ(datagram.sender, kLidar);
      EXPECT_EQ(datagram.sender_port, 4321);
      EXPECT_EQ(datagram.destination_port, 2368);
      EXPECT_GE(datagram.stamp, before - Duration(1'000'000));
      EXPECT_LE(datagram.stamp, base.now());
      for (size_t i = 0; i < datagram.payload.size(); ++i) {
        ASSERT_EQ(datagram.payload[i], static_cast<uint8_t>(i * 7));
      }
    });
    ASSERT_TRUE(count);
    EXPECT_EQ(sizes, (std::vector<size_t>{1206, 0}));
    EXPECT_EQ(*socket->read(batch, [](const Datagram&) {}), 0U);
  });
}

TEST(UdpTap, TheKernelRejectsOtherSenders) {
  run_on_wire([](const Wire& wire) {
    const host::TimeBase base;
    UdpOptions options{.interface = "lo", .tap = true};
    options.senders = {kLidar};
    auto of_lidar = UdpSource::open(options, base);
    options.senders = {kOtherHost};
    auto of_other = UdpSource::open(options, base);
    ASSERT_TRUE(of_lidar && of_other);
    for (int i = 0; i < 200; ++i) wire.send({});
    host::MessageBatch batch(256, 2048);
    EXPECT_EQ(*of_lidar->read(batch, [](const Datagram&) {}), 200U);
    EXPECT_LT(*of_other->read(batch, [](const Datagram&) {}), 50U);  // 1 in 256 passes
  });
}

TEST(UdpTap, CountsWhatTheKernelDrops) {
  run_on_wire([](const Wire& wire) {
    const host::TimeBase base;
    UdpSource tap = open_tap_source(base, 20'000);
    constexpr size_t kSent = 200;
    for (size_t i = 0; i < kSent; ++i) wire.send({});
    host::MessageBatch batch(256, 2048);
    const size_t received = *tap.read(batch, [](const Datagram&) {});
    EXPECT_LT(received, kSent);
    wire.send({});  // with it the kernel reports what it has dropped
    EXPECT_EQ(*tap.read(batch, [](const Datagram&) {}), 1U);
    EXPECT_EQ(received + tap.dropped(), kSent);
  });
}

TEST(UdpTap, SaysWhatIsMissing) {
  const auto tap = open_tap("no-interface", 2368);
  ASSERT_FALSE(tap);
  EXPECT_EQ(tap.error().message(), "no-interface: no such interface");
  EXPECT_TRUE(UdpOptions{.tap = true}.invalid());
  EXPECT_TRUE((UdpOptions{.address = "10.0.0.1", .interface = "lo", .tap = true}.invalid()));
  EXPECT_TRUE((UdpOptions{.port = 0, .interface = "lo", .tap = true}.invalid()));
  EXPECT_FALSE((UdpOptions{.interface = "lo", .tap = true}.invalid()));
}

TEST(UdpTap, DamagedPacketsAreParsedWithinTheirBytes) {
  const Bytes packet = make_packet({.payload = 64});
  for (size_t size = 0; size <= packet.size(); ++size) {
    const Bytes cut(packet.begin(), packet.begin() + static_cast<std::ptrdiff_t>(size));
    const auto datagram = parse_tapped(cut);
    ASSERT_EQ(datagram.has_value(), size >= 28) << size;
    if (datagram) {
      EXPECT_EQ(datagram->payload.size(), size - 28);
    }
  }
  Bytes wrong = packet;
  for (const uint8_t version_and_length : Bytes{0x00, 0x44, 0x65, 0x4F}) {
    wrong[0] = version_and_length;
    const auto datagram = parse_tapped(wrong);  // 0x4F: the header takes 60 bytes
    EXPECT_EQ(datagram.has_value(), version_and_length == 0x4F);
  }
}

}  // namespace
}  // namespace infuse::lidar
