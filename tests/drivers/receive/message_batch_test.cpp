#include "drivers/receive/message_batch.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <ctime>

namespace infuse::receive {
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

TEST(AncillaryData, IsZeroIfNothingIsReported) {
  const AncillaryData ancillary = ControlBuffer().parse();
  EXPECT_EQ(ancillary.wall_ns, 0);
  EXPECT_EQ(ancillary.hardware_ns, 0);
  EXPECT_EQ(ancillary.dropped, 0U);
}

}  // namespace
}  // namespace infuse::receive
