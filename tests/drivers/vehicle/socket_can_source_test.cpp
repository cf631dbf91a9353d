#include "drivers/vehicle/socket_can_source.hpp"

#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/error.h>

#include <cstring>

namespace infuse::vehicle {
namespace {

std::span<const uint8_t> bytes_of(const can_frame& frame) {
  return {reinterpret_cast<const uint8_t*>(&frame), sizeof(frame)};
}

can_frame make_raw_frame(canid_t id, std::initializer_list<uint8_t> data) {
  can_frame frame{};
  frame.can_id = id;
  frame.len = static_cast<uint8_t>(data.size());
  std::copy(data.begin(), data.end(), frame.data);
  return frame;
}

CanFrame make_error_frame(uint32_t error_class, uint8_t controller = 0) {
  CanFrame frame;
  EXPECT_TRUE(parse_socket_can(
      bytes_of(make_raw_frame(error_class | CAN_ERR_FLAG, {0, controller, 0, 0})), frame));
  EXPECT_TRUE(frame.error);
  return frame;
}

TEST(SocketCan, ReadsAClassicFrame) {
  CanFrame frame;
  ASSERT_TRUE(parse_socket_can(bytes_of(make_raw_frame(0x260, {8, 0xFF})), frame));
  EXPECT_EQ(frame.id, 0x260U);
  EXPECT_FALSE(frame.extended || frame.remote || frame.error || frame.fd);
  EXPECT_EQ(std::vector<uint8_t>(frame.payload().begin(), frame.payload().end()),
            (std::vector<uint8_t>{8, 0xFF}));
}

TEST(SocketCan, ReadsExtendedAndRemoteFrames) {
  CanFrame frame;
  ASSERT_TRUE(parse_socket_can(bytes_of(make_raw_frame(0x18FEF100U | CAN_EFF_FLAG, {1})), frame));
  EXPECT_EQ(frame.id, 0x18FEF100U);
  EXPECT_TRUE(frame.extended);
  ASSERT_TRUE(parse_socket_can(bytes_of(make_raw_frame(0x123 | CAN_RTR_FLAG, {1, 2})), frame));
  EXPECT_EQ(frame.id, 0x123U);
  EXPECT_TRUE(frame.remote);
  EXPECT_EQ(frame.payload().size(), 0U);
}

TEST(SocketCan, ReadsAnFdFrame) {
  canfd_frame fd{};
  fd.can_id = 0x400;
  fd.len = 64;
  fd.flags = CANFD_BRS;
  for (size_t i = 0; i < 64; ++i) fd.data[i] = static_cast<uint8_t>(i);
  CanFrame frame;
  ASSERT_TRUE(parse_socket_can({reinterpret_cast<const uint8_t*>(&fd), sizeof(fd)}, frame));
  EXPECT_TRUE(frame.fd);
  EXPECT_EQ(frame.fd_flags, CANFD_BRS);
  ASSERT_EQ(frame.payload().size(), 64U);
  EXPECT_EQ(frame.payload()[63], 63);
}

TEST(SocketCan, ClampsATooLargeLength) {
  can_frame lying = make_raw_frame(1, {});
  lying.len = 200;
  CanFrame frame;
  ASSERT_TRUE(parse_socket_can(bytes_of(lying), frame));
  EXPECT_EQ(frame.payload().size(), 8U);
  EXPECT_FALSE(parse_socket_can(bytes_of(lying).first(15), frame));
}

TEST(SocketCan, ReportsMissingInterface) {
  const auto source = SocketCanSource::open({.interface = "nosuchcan0"}, host::TimeBase());
  ASSERT_FALSE(source.has_value());
  EXPECT_FALSE(source.error().what.empty());
  EXPECT_TRUE(SocketCanOptions{.interface = ""}.invalid());
  EXPECT_TRUE(SocketCanOptions{.interface = "a-name-that-is-too-long"}.invalid());
}

TEST(BusErrors, FollowsTheControllerIntoBusOffAndBack) {
  BusErrors errors;
  EXPECT_EQ(errors.state(), BusState::kErrorActive);
  errors.process(make_error_frame(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_WARNING));
  EXPECT_EQ(errors.state(), BusState::kErrorWarning);
  errors.process(make_error_frame(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_PASSIVE));
  EXPECT_EQ(errors.state(), BusState::kErrorPassive);
  errors.process(make_error_frame(CAN_ERR_BUSOFF));
  EXPECT_EQ(errors.state(), BusState::kBusOff);
  errors.process(make_error_frame(CAN_ERR_RESTARTED));
  EXPECT_EQ(errors.state(), BusState::kErrorActive);
}

TEST(BusErrors, AReceivedFrameEndsBusOff) {
  BusErrors errors;
  errors.process(make_error_frame(CAN_ERR_BUSOFF));
  CanFrame frame;
  ASSERT_TRUE(parse_socket_can(bytes_of(make_raw_frame(0x10, {1})), frame));
  errors.process(frame);
  EXPECT_EQ(errors.state(), BusState::kErrorActive);
}

}  // namespace
}  // namespace infuse::vehicle
