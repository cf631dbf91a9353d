#include "daemon/sensors/reopening_source.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace infuse::daemon {
namespace {

Stamp at_ms(int64_t ms) { return Stamp::from_ns(ms * 1'000'000); }

TEST(ReopeningSource, RetryDelayDoublesAndIsResetByAnOpenSource) {
  bool there = false;
  std::vector<int64_t> tries;
  int64_t now = 0;
  ReopeningSource<int> source("test", [&]() -> Result<int> {
    tries.push_back(now);
    if (!there) return fail("not there", "somewhere");
    return 7;
  });
  EXPECT_FALSE(source.state().open);
  for (; now < 10'000; now += 10) EXPECT_FALSE(source.reopen_if_due(at_ms(now)));
  // After 100, 200, 400, 800, 1600 ms, then every 2 s.
  EXPECT_EQ(tries, (std::vector<int64_t>{0, 100, 300, 700, 1500, 3100, 5100, 7100, 9100}));
  EXPECT_STREQ(source.state().problem.data(), "somewhere: not there");
  there = true;
  for (; source.get() == nullptr && now < 20'000; now += 10) source.reopen_if_due(at_ms(now));
  ASSERT_NE(source.get(), nullptr);
  EXPECT_EQ(tries.back(), 11'100);
  EXPECT_TRUE(source.state().open);
  EXPECT_EQ(source.state().open_count, 1U);
  source.close({"pulled out", "somewhere", ""}, at_ms(now));
  EXPECT_EQ(source.get(), nullptr);
  EXPECT_FALSE(source.reopen_if_due(at_ms(now + 50)));
  EXPECT_TRUE(source.reopen_if_due(at_ms(now + 100)));
  EXPECT_EQ(source.state().open_count, 2U);
}

TEST(ReopeningSource, RetryNowSkipsTheDelay) {
  int tries = 0;
  ReopeningSource<int> source("test", [&]() -> Result<int> {
    if (++tries < 5) return fail("not there", "somewhere");
    return 7;
  });
  for (int64_t now = 0; now < 1000; now += 10) source.reopen_if_due(at_ms(now));
  EXPECT_EQ(tries, 4);
  EXPECT_FALSE(source.reopen_if_due(at_ms(1000)));
  source.retry_now();
  EXPECT_TRUE(source.reopen_if_due(at_ms(1010)));
}

}  // namespace
}  // namespace infuse::daemon
