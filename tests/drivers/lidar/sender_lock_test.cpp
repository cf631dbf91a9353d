#include "drivers/lidar/sender_lock.hpp"
#include "tests/stamp_at.hpp"

#include <gtest/gtest.h>

#include <random>

namespace infuse::lidar {
namespace {

constexpr uint32_t kSensor = 0xC0A8'01C9, kOther = 0xC0A8'0163;
constexpr double kSensorHz = 754;  // a VLP-16

/// Feeds a sensor's packets from `from` to `to`, seconds, and returns how many were used.
int feed(SenderLock& lock, uint32_t sender, double from, double to, double hz = kSensorHz) {
  int used = 0;
  for (double t = from; t < to; t += 1 / hz) used += lock.accept(sender, at(t)) ? 1 : 0;
  return used;
}

TEST(SenderLock, OneForgedPacketCostsAtMostAWindow) {
  SenderLock lock(0);
  EXPECT_TRUE(lock.accept(kOther, at(0)));
  EXPECT_EQ(feed(lock, kSensor, 0.001, 1.9), 0);
  feed(lock, kSensor, 1.9, 2.1);
  EXPECT_EQ(lock.sender(), kSensor);
  EXPECT_EQ(lock.previous(), kOther);
  EXPECT_EQ(lock.changes(), 1U);
  EXPECT_EQ(feed(lock, kSensor, 2.1, 3.1), static_cast<int>(kSensorHz) + 1);
}

TEST(SenderLock, ATrickleOfForgedPacketsDoesNotHoldIt) {
  SenderLock lock(0);
  lock.accept(kOther, at(0));
  for (double t = 0; t < 10; t += 0.5) {
    lock.accept(kOther, at(t));
    feed(lock, kSensor, t + 0.001, t + 0.5);
  }
  EXPECT_EQ(lock.sender(), kSensor);
  EXPECT_EQ(lock.changes(), 1U);
}

TEST(SenderLock, AnExchangedUnitIsUsedAfterTheSilence) {
  SenderLock lock(0);
  feed(lock, kSensor, 0, 5);
  EXPECT_FALSE(lock.accept(kOther, at(5.5)));  // before the silence is over
  EXPECT_GT(feed(lock, kOther, 60, 61), 700);
  EXPECT_EQ(lock.sender(), kOther);
  EXPECT_EQ(lock.rival(), 0U);
}

TEST(SenderLock, ASecondSensorIsNamedAndDoesNotTakeOver) {
  SenderLock lock(0);
  for (double t = 0; t < 6; t += 1 / kSensorHz) {
    EXPECT_TRUE(lock.accept(kSensor, at(t)));
    EXPECT_FALSE(lock.accept(kOther, at(t + 1e-4)));
  }
  EXPECT_EQ(lock.rival(), kOther);
  EXPECT_EQ(lock.changes(), 0U);
  feed(lock, kSensor, 6, 11);  // the other one has ended
  EXPECT_EQ(lock.rival(), 0U);
}

TEST(SenderLock, AFloodFromRandomAddressesNeitherTakesOverNorIsARival) {
  SenderLock lock(0);
  std::mt19937 random(1);
  int used = 0;
  for (int i = 0; i < 7540; ++i) {
    const Stamp stamp = at(i / kSensorHz);
    used += lock.accept(kSensor, stamp) ? 1 : 0;
    for (int k = 0; k < 100; ++k) lock.accept(static_cast<uint32_t>(random()) | 1, stamp);
  }
  EXPECT_EQ(used, 7540);
  EXPECT_EQ(lock.rival(), 0U);
}

// Its share of the others' packets is above a ninth, so it is found whatever the others do.
TEST(SenderLock, FindsTheSensorAmongForgedAddresses) {
  SenderLock lock(0);
  std::mt19937 random(2);
  lock.accept(kOther, at(0));
  for (int i = 0; i < 3000; ++i) {
    const Stamp stamp = at(i / kSensorHz);
    lock.accept(kSensor, stamp);
    for (int k = 0; k < 4; ++k) lock.accept(static_cast<uint32_t>(random()) | 1, stamp);
  }
  EXPECT_EQ(lock.sender(), kSensor);
}

TEST(SenderLock, AConfiguredSenderIsKept) {
  SenderLock lock(kSensor);
  EXPECT_TRUE(lock.refuses(kOther));
  EXPECT_EQ(feed(lock, kOther, 0, 10), 0);
  EXPECT_TRUE(lock.accept(kSensor, at(11)));
  EXPECT_EQ(lock.changes(), 0U);
}

TEST(SenderLock, AStepBackOfTimeKeepsTheSender) {
  SenderLock lock(0);
  feed(lock, kSensor, 100, 105);
  EXPECT_FALSE(lock.accept(kOther, at(1)));
  EXPECT_GT(feed(lock, kSensor, 1, 6), 3700);
  EXPECT_EQ(lock.changes(), 0U);
}

}  // namespace
}  // namespace infuse::lidar
