#include "daemon/calibration/background.hpp"

#include <gtest/gtest.h>

#include <atomic>

namespace infuse::daemon {
namespace {

Stamp at(int64_t seconds) { return Stamp::from_ns(seconds * 1'000'000'000); }
constexpr Duration kTenSeconds{10'000'000'000};

TEST(Background, AResultIsVisibleAtItsStatedTimeHoweverQuickOrSlow) {
  for (const int milliseconds : {0, 200}) {
    Background background(true);
    std::atomic<int> result = 0;
    EXPECT_FALSE(background.busy());
    background.start(at(100), kTenSeconds, [&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
      result = 7;
    });
    EXPECT_TRUE(background.busy());
    EXPECT_FALSE(background.take(at(100)));
    EXPECT_FALSE(background.take(at(109)));
    EXPECT_TRUE(background.take(at(110)));  // waited for
    EXPECT_EQ(result, 7);
    EXPECT_FALSE(background.busy());
    EXPECT_FALSE(background.take(at(120)));
  }
}

TEST(Background, LiveNobodyWaits) {
  Background background(false);
  std::atomic<bool> go = false;
  background.start(at(0), kTenSeconds, [&] {
    while (!go) std::this_thread::yield();
  });
  EXPECT_FALSE(background.take(at(60)));
  EXPECT_TRUE(background.busy());
  go = true;
  while (!background.take(at(61))) std::this_thread::yield();
  EXPECT_FALSE(background.busy());
}

TEST(Background, DoesOnePieceOfWorkAfterTheOther) {
  Background background(true);
  int sum = 0;
  for (int i = 1; i <= 50; ++i) {
    background.start(at(i), Duration::zero(), [&sum, i] { sum += i; });
    EXPECT_TRUE(background.take(at(i)));
  }
  EXPECT_EQ(sum, 50 * 51 / 2);
}

}  // namespace
}  // namespace infuse::daemon
