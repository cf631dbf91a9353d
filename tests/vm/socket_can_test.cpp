// Needs a kernel with CAN and a virtual bus vcan0 that may be taken down: ./dev vm.

#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <vector>

#include "drivers/vehicle/socket_can_source.hpp"

namespace infuse::vehicle {
namespace {

using host::FileDescriptor;

class VirtualBus : public testing::Test {
 protected:
  void SetUp() override {
    if (if_nametoindex("vcan0") == 0) GTEST_SKIP() << "no vcan0 here: ./dev vm";
    sender_ = open_sender("vcan0");
  }
  void TearDown() override {
    if (sender_) set_interface_up(true);
  }

  static FileDescriptor open_sender(const char* interface) {
    FileDescriptor sender(socket(PF_CAN, SOCK_RAW, CAN_RAW));
    const int on = 1;
    setsockopt(sender.get(), SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof(on));
    sockaddr_can bus{};
    bus.can_family = AF_CAN;
    bus.can_ifindex = static_cast<int>(if_nametoindex(interface));
    EXPECT_EQ(bind(sender.get(), reinterpret_cast<sockaddr*>(&bus), sizeof(bus)), 0);
    return sender;
  }

  void set_interface_up(bool up) const {
    ifreq request{};
    std::string("vcan0").copy(request.ifr_name, IFNAMSIZ - 1);
    ASSERT_EQ(ioctl(sender_.get(), SIOCGIFFLAGS, &request), 0);
    request.ifr_flags = static_cast<short>(up ? request.ifr_flags | IFF_UP  // NOLINT
                                              : request.ifr_flags & ~IFF_UP);
    ASSERT_EQ(ioctl(sender_.get(), SIOCSIFFLAGS, &request), 0) << "needs root";
    int error = 0;  // of the interface that went down, to the sender too
    socklen_t size = sizeof(error);
    getsockopt(sender_.get(), SOL_SOCKET, SO_ERROR, &error, &size);
  }

  void send(canid_t id, uint8_t length, uint8_t first, size_t size = CAN_MTU) const {
    send(sender_, id, length, first, size);
  }
  static void send(const FileDescriptor& sender, canid_t id, uint8_t length, uint8_t first,
                   size_t size = CAN_MTU) {
    canfd_frame frame{};
    frame.can_id = id;
    frame.len = length;
    frame.data[0] = first;
    frame.data[1] = first;
    ASSERT_EQ(write(sender.get(), &frame, size), static_cast<ssize_t>(size));
  }

  SocketCanSource open(const SocketCanOptions& options) const {
    auto source = SocketCanSource::open(options, time_base_);
    EXPECT_TRUE(source.has_value()) << source.error().message();
    return *std::move(source);
  }

  std::vector<CanFrame> read_all(SocketCanSource& source) {
    std::vector<CanFrame> frames;
    while (true) {
      const auto count = source.read(batch_, [&](const CanFrame& f) { frames.push_back(f); });
      EXPECT_TRUE(count.has_value());
      if (!count || *count == 0) return frames;
    }
  }

  host::TimeBase time_base_;
  host::MessageBatch batch_ = make_can_batch();
  FileDescriptor sender_;
};

TEST_F(VirtualBus, GivesClassicAndFdFramesInOrderWithTheKernelsStamps) {
  SocketCanSource source = open({.interface = "vcan0"});
  EXPECT_TRUE(source.up());
  const Stamp before = time_base_.now();
  send(0x123, 8, 1);
  send(0x18FEF100U | CAN_EFF_FLAG, 3, 2);
  send(0x400, 64, 3, CANFD_MTU);
  const Stamp after = time_base_.now();
  const auto frames = read_all(source);
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[0].id, 0x123U);
  EXPECT_TRUE(frames[1].extended);
  EXPECT_TRUE(frames[2].fd);
  EXPECT_EQ(frames[2].payload().size(), 64U);
  EXPECT_EQ(frames[0].interface_name(), "vcan0");
  constexpr Duration kTolerance{1'000'000};
  EXPECT_GE(frames[0].stamp, before - kTolerance);
  EXPECT_LE(frames[0].stamp, frames[2].stamp);
  EXPECT_LE(frames[2].stamp, after + kTolerance);
  EXPECT_FALSE(source.stamped_by_hardware());  // a virtual bus has no clock
}

TEST_F(VirtualBus, TheKernelPassesOnlyTheSubscribedIdentifiers) {
  SocketCanSource source =
      open({.interface = "vcan0", .identifiers = {{0x10, false}, {0x20, true}}});
  send(0x10, 1, 1);
  send(0x10 | CAN_EFF_FLAG, 1, 2);
  send(0x20, 1, 3);
  send(0x20 | CAN_EFF_FLAG, 1, 4);
  send(0x30, 1, 5);
  const auto frames = read_all(source);
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].data[0], 1);
  EXPECT_EQ(frames[1].data[0], 4);
}

TEST_F(VirtualBus, ErrorFramesPassTheFiltersAndUpdateTheBusState) {
  SocketCanSource source = open({.interface = "vcan0", .identifiers = {{0x10, false}}});
  send(CAN_ERR_FLAG | CAN_ERR_CRTL, 8, CAN_ERR_CRTL_RX_PASSIVE);
  EXPECT_EQ(read_all(source).size(), 1U);
  EXPECT_EQ(source.bus_errors().state(), BusState::kErrorPassive);
  send(CAN_ERR_FLAG | CAN_ERR_BUSOFF, 8, 0);
  EXPECT_EQ(read_all(source).size(), 1U);
  EXPECT_EQ(source.bus_errors().state(), BusState::kBusOff);
}

TEST_F(VirtualBus, SurvivesTheInterfaceGoingDownAndUp) {
  SocketCanSource source = open({.interface = "vcan0"});
  set_interface_up(false);
  pollfd waiting{source.descriptor(), POLLIN, 0};
  EXPECT_EQ(poll(&waiting, 1, 1000), 1);  // the kernel reports it
  EXPECT_EQ(read_all(source).size(), 0U);
  EXPECT_FALSE(source.up());
  set_interface_up(true);
  EXPECT_TRUE(source.up());
  send(0x77, 1, 9);
  const auto frames = read_all(source);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].id, 0x77U);
}

TEST_F(VirtualBus, TwoBusesAreReceivedSeparatelyAndOneGoesDownAlone) {
  ASSERT_NE(if_nametoindex("vcan1"), 0U);
  const FileDescriptor other = open_sender("vcan1");
  SocketCanSource first = open({.interface = "vcan0"});
  SocketCanSource second = open({.interface = "vcan1"});
  send(0x10, 1, 1);
  send(other, 0x10, 1, 2);
  const auto of_first = read_all(first), of_second = read_all(second);
  ASSERT_EQ(of_first.size(), 1U);
  ASSERT_EQ(of_second.size(), 1U);
  EXPECT_EQ(of_first[0].data[0], 1);
  EXPECT_EQ(of_second[0].data[0], 2);
  EXPECT_EQ(of_second[0].interface_name(), "vcan1");
  set_interface_up(false);
  EXPECT_EQ(read_all(first).size(), 0U);
  EXPECT_FALSE(first.up());
  EXPECT_TRUE(second.up());
  send(other, 0x11, 1, 3);
  EXPECT_EQ(read_all(second).size(), 1U);
}

TEST_F(VirtualBus, CountsWhatTheKernelDropped) {
  SocketCanSource source = open({.interface = "vcan0", .receive_buffer = 8192});
  constexpr uint64_t kSent = 2000;
  for (uint64_t i = 0; i < kSent; ++i) send(0x55, 8, 0);
  const uint64_t received = read_all(source).size();
  EXPECT_LT(received, kSent);
  send(0x55, 8, 0);
  const uint64_t last = read_all(source).size();
  EXPECT_EQ(received + last + source.dropped(), kSent + 1);
}

}  // namespace
}  // namespace infuse::vehicle
