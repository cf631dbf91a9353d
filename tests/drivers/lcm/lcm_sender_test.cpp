#include "drivers/lcm/lcm_sender.hpp"

#include <gtest/gtest.h>

#include <random>

#include "drivers/lcm/lcm_types.hpp"
#include "tests/drivers/lcm/lcm_receiver.hpp"

namespace infuse::lcm {
namespace {

TEST(LcmTypes, HaveTheFingerprintsOfLcmGen) {
  EXPECT_EQ(fingerprint(PoseMessage{}), kPoseFingerprint);
  EXPECT_EQ(fingerprint(SweepMessage{}), kSweepFingerprint);
  EXPECT_EQ(fingerprint(AlertMessage{}), kAlertFingerprint);
}

TEST(LcmTypes, MembersAreBigEndianInTheOrderOfTheDefinition) {
  std::vector<uint8_t> bytes;
  encode(SweepMessage{.utime = 1,
                      .lidar = "ab",
                      .deskewed = true,
                      .x = {1.5F},
                      .y = {-2},
                      .z = {0},
                      .reflectivity = {0.25F},
                      .ring = {258}},
         bytes);
  const std::vector<uint8_t> body = {0,   0, 0, 0, 0, 0, 0,    1,    0,    0, 0, 3,    'a',
                                     'b', 0, 1, 0, 0, 0, 1,    0x3F, 0xC0, 0, 0, 0xC0, 0,
                                     0,   0, 0, 0, 0, 0, 0x3E, 0x80, 0,    0, 1, 2};
  ASSERT_EQ(bytes.size(), 8 + body.size());
  EXPECT_TRUE(std::equal(body.begin(), body.end(), bytes.begin() + 8));
}

TEST(LcmSender, MessagesOfEverySizeArriveWhole) {
  LcmReceiver receiver;
  if (!receiver.works()) GTEST_SKIP() << "no multicast on the loopback";
  auto sender = LcmSender::open(receiver.options());
  ASSERT_TRUE(sender) << sender.error().message();
  std::mt19937 random(1);
  const std::string channel = "INFUSE_SWEEP_top";
  const size_t largest_short = 65'507 - 8 - channel.size() - 1;
  const size_t first = 65'507 - 20 - channel.size() - 1;
  uint32_t number = 0;
  for (const size_t size : {size_t{0}, size_t{1}, largest_short, largest_short + 1, first + 65'487,
                            first + 65'487 + 1}) {
    std::vector<uint8_t> payload(size);
    for (uint8_t& byte : payload) byte = static_cast<uint8_t>(random());
    ASSERT_TRUE(sender->send(channel, payload));
    const auto received = receiver.next();
    ASSERT_TRUE(received) << size;
    EXPECT_EQ(received->channel, channel);
    EXPECT_EQ(received->payload, payload);
    EXPECT_EQ(received->number, number++);
    EXPECT_EQ(received->datagrams,
              size <= largest_short ? 1 : 1 + (size - first + 65'486) / 65'487);
  }
}

TEST(LcmSender, RefusesWhatNoReceiverTakes) {
  EXPECT_EQ(SenderOptions{}.invalid(), std::nullopt);
  EXPECT_TRUE(SenderOptions{.group = "192.168.1.1"}.invalid());
  EXPECT_TRUE(SenderOptions{.port = 0}.invalid());
  EXPECT_TRUE(SenderOptions{.ttl = 256}.invalid());
  EXPECT_TRUE(SenderOptions{.interface = "eth0"}.invalid());
  auto sender = LcmSender::open({.interface = "127.0.0.1"});
  ASSERT_TRUE(sender);
  EXPECT_FALSE(sender->send("", {}));
  EXPECT_FALSE(sender->send(std::string(64, 'c'), {}));
}

}  // namespace
}  // namespace infuse::lcm
