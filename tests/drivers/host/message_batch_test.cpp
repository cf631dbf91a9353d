#include "drivers/host/message_batch.hpp"

#include <gtest/gtest.h>
#include <linux/errqueue.h>
#include <linux/net_tstamp.h>
#include <sys/socket.h>

#include <array>
#include <cstring>
#include <ctime>

#include "drivers/host/file_descriptor.hpp"

namespace infuse::host {
namespace {

/// Control messages as the kernel writes them.
class ControlBuffer {
 public:
  template <class Value>
  void add(int type, const Value& value) {
    auto* header = reinterpret_cast<cmsghdr*>(bytes_.data() + size_);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = type;
    header->cmsg_len = CMSG_LEN(sizeof(value));
    std::memcpy(CMSG_DATA(header), &value, sizeof(value));
    size_ += CMSG_SPACE(sizeof(value));
  }
  AncillaryData parse() {
    msghdr header{};
    header.msg_control = bytes_.data();
    header.msg_controllen = size_;
    return AncillaryData::parse(header);
  }

 private:
  alignas(cmsghdr) std::array<char, 256> bytes_{};
  size_t size_ = 0;
};

TEST(AncillaryData, ContainsTheStampsOfBothClocksAndTheDrops) {
  ControlBuffer controls;
  controls.add(SCM_TIMESTAMPNS, timespec{1'700'000'000, 250});
  controls.add(SCM_TIMESTAMPING, std::array<timespec, 3>{{{0, 0}, {0, 0}, {12, 34}}});
  controls.add(SO_RXQ_OVFL, uint32_t{9});
  const AncillaryData ancillary = controls.parse();
  EXPECT_EQ(ancillary.wall_ns, 1'700'000'000'000'000'250);
  EXPECT_EQ(ancillary.hardware_ns, 12'000'000'034);
  EXPECT_EQ(ancillary.dropped, 9U);
}

TEST(AncillaryData, NamesTheInterfaceThatStamped) {
  ControlBuffer controls;
  controls.add(SCM_TIMESTAMPING_PKTINFO, scm_ts_pktinfo{7, 1248, {}});
  controls.add(SCM_TIMESTAMPING, std::array<timespec, 3>{{{0, 0}, {0, 0}, {12, 34}}});
  const AncillaryData ancillary = controls.parse();
  EXPECT_EQ(ancillary.interface, 7U);
  EXPECT_EQ(ancillary.hardware_ns, 12'000'000'034);
  EXPECT_EQ(ancillary.wall_ns, 0) << "the kernel's own stamp was not asked for";
}

// The kernel's own stamps in the control message that hardware stamps come in, over the loopback,
// whose interface makes none.
TEST(MessageBatch, StampsOfTheKernelComeInTheMessageOfHardwareStamps) {
  const FileDescriptor receiver(socket(AF_INET, SOCK_DGRAM, 0)),
      sender(socket(AF_INET, SOCK_DGRAM, 0));
  sockaddr_in local{};
  local.sin_family = AF_INET;
  local.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(bind(receiver.get(), reinterpret_cast<sockaddr*>(&local), sizeof(local)), 0);
  socklen_t size = sizeof(local);
  getsockname(receiver.get(), reinterpret_cast<sockaddr*>(&local), &size);
  const int wanted = SOF_TIMESTAMPING_RX_SOFTWARE | SOF_TIMESTAMPING_SOFTWARE |
                     SOF_TIMESTAMPING_RX_HARDWARE | SOF_TIMESTAMPING_RAW_HARDWARE |
                     SOF_TIMESTAMPING_OPT_PKTINFO;
  ASSERT_EQ(setsockopt(receiver.get(), SOL_SOCKET, SO_TIMESTAMPING, &wanted, sizeof(wanted)), 0);
  const TimeBase base;
  WallStamps stamps(base);
  MessageBatch batch(4, 64);
  const Stamp before = base.now();
  // The first message may come before the kernel has begun to stamp.
  for (int i = 0; i < 3; ++i) {
    ASSERT_EQ(sendto(sender.get(), "x", 1, 0, reinterpret_cast<sockaddr*>(&local), sizeof(local)),
              1);
  }
  ASSERT_EQ(batch.receive(receiver.get(), stamps), 3);
  const Stamp after = base.now();
  EXPECT_EQ(batch[2].hardware_ns, 0);
  EXPECT_EQ(batch[2].interface, 0U);
  EXPECT_GE(batch[2].stamp, before - Duration(1'000'000));
  EXPECT_LE(batch[2].stamp, after);
}

TEST(AncillaryData, IsZeroIfNothingIsReported) {
  const AncillaryData ancillary = ControlBuffer().parse();
  EXPECT_EQ(ancillary.wall_ns, 0);
  EXPECT_EQ(ancillary.hardware_ns, 0);
  EXPECT_EQ(ancillary.dropped, 0U);
}

}  // namespace
}  // namespace infuse::host
