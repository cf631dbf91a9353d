#include "drivers/measurement/clock_model.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <random>
#include <vector>
#include "tests/drivers/measurement/simulated_device.hpp"

namespace infuse {
namespace {

TEST(ClockModel, CountsAJumpAndWithdrawsTrustUntilSettled) {
  for (const Duration jump :
       std::vector<Duration>{-20min, -10s, -700ms, -20ms, 20ms, 700ms, 10s, 20min}) {
    Device device{.skew_ppm = 50, .phase = 3h};
    ClockModel model{{}};
    max_error(model, device, 20s);
    ASSERT_TRUE(model.state().trusted);
    device.phase += jump;
    // During the confirmation a small jump looks like a delay, so trust is withdrawn only then.
    const Stamp end = device.now + 600ms;
    bool distrusted_at_once = false;
    while (device.now < end) {
      const Device::Message message = device.next();
      const Stamp stamp = model.update(message.device, message.host);
      distrusted_at_once |= !model.state().trusted;
      if (!model.state().trusted) {
        EXPECT_LT(message.host - stamp, 5ms);
      }
    }
    EXPECT_TRUE(distrusted_at_once);
    EXPECT_EQ(model.state().jumps, 1) << jump.count();
    EXPECT_FALSE(model.state().trusted);
    EXPECT_STREQ(model.state().reason, "not settled after a jump");
    EXPECT_LT(max_error(model, device, 1min), 3us) << jump.count();
    EXPECT_TRUE(model.state().trusted);
    EXPECT_EQ(model.state().jumps, 1);
    EXPECT_EQ(model.state().source, jump > -500ms && jump < 500ms ? ClockState::Source::kTopOfHour
                                                                  : ClockState::Source::kPowerUp);
  }
}

TEST(ClockModel, CountsAStepOfTheHostClockAsAJump) {
  for (const Duration step : std::vector<Duration>{-3s, 3s}) {
    Device device;
    ClockModel model{{}};
    max_error(model, device, 20s);
    const Stamp end = device.now + 20s;
    Duration worst{0};
    while (device.now < end) {
      const Device::Message message = device.next();
      const Stamp stamp = model.update(message.device, message.host + step);
      if (model.state().trusted) {
        worst = std::max(worst, std::chrono::abs(stamp - message.truth - step));
      }
    }
    EXPECT_EQ(model.state().jumps, 1);
    EXPECT_TRUE(model.state().trusted);
    EXPECT_LT(worst, 3us);
  }
}

TEST(ClockModel, WithdrawsTrustAfterASmallJumpUntilItLeavesTheWindow) {
  for (const Duration jump : std::vector<Duration>{-4ms, -1ms, 1ms, 4ms}) {
    Device device;
    ClockModel model{{}};
    max_error(model, device, 90s);
    device.phase += jump;
    const Stamp second = device.now + 2s;  // until a part of the window is complete
    while (device.now < second) {
      const Device::Message message = device.next();
      model.update(message.device, message.host);
    }
    // A jump below about the spread of the delay (200 us) plus 0.1 ms passes for delay.
    EXPECT_LT(max_error(model, device, 3min), 500us) << jump.count();
    EXPECT_TRUE(model.state().trusted);
    EXPECT_EQ(model.state().jumps, 0);
    EXPECT_LT(max_error(model, device, 10s), 2us) << jump.count();
  }
}

TEST(ClockModel, IgnoresBadPackets) {
  Device device{.skew_ppm = 10};
  ClockModel model{{}};
  std::mt19937 random(3);
  Duration worst{0};
  for (int i = 0; i < 200'000; ++i) {
    const Device::Message message = device.next();
    const Duration garbage{std::uniform_int_distribution<int64_t>(0, 4'294'967'295'000)(random)};
    if (i % 50 == 7) {
      const Stamp stamp = model.update(garbage, message.host);
      EXPECT_LE(stamp, message.host);
      EXPECT_LE(message.host - stamp, 1s);
    }
    const Stamp stamp = model.update(message.device, message.host);
    if (model.state().trusted) worst = std::max(worst, std::chrono::abs(stamp - message.truth));
  }
  EXPECT_EQ(model.state().jumps, 0);
  EXPECT_TRUE(model.state().trusted);
  EXPECT_LT(worst, 2us);
}

TEST(ClockModel, IsNotMovedByAStallOfTheHost) {
  Device device;
  ClockModel model{{}};
  max_error(model, device, 20s);
  // Nothing is read for 0.8 s, then everything at once.
  const Stamp resumed = device.now + 800ms;
  Duration worst{0};
  while (device.now < resumed) {
    const Device::Message message = device.next();
    const Stamp stamp = model.update(message.device, resumed);
    worst = std::max(worst, std::chrono::abs(stamp - message.truth));
  }
  EXPECT_LT(worst, 2us);
  EXPECT_LT(max_error(model, device, 1min), 2us);
  EXPECT_EQ(model.state().jumps, 0);
  EXPECT_TRUE(model.state().trusted);
}

// Ten messages a second: within the time of a jump's confirmation only five come.
TEST(ClockModel, TakesNoLongDelaysOfASlowStreamForAJump) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Device device{.period = 100ms, .mean_delay = 5ms, .random = std::mt19937(seed)};
    ClockModel model{{}};
    max_error(model, device, 30min);
    EXPECT_EQ(model.state().jumps, 0) << seed;
    device.phase -= 100ms;
    max_error(model, device, 1min);
    EXPECT_EQ(model.state().jumps, 1) << seed;
  }
}

TEST(ClockModel, IsNotTrustedBeforeItHasEnoughSamples) {
  ClockModel model{{}};
  EXPECT_FALSE(model.state().trusted);
  EXPECT_STREQ(model.state().reason, "no sample yet");
  EXPECT_EQ(model.to_host(5s), Stamp::from_ns(5'000'000'000));
  Device device;
  max_error(model, device, 4900ms);
  EXPECT_FALSE(model.state().trusted);
  EXPECT_STREQ(model.state().reason, "not settled after the start");
  max_error(model, device, 200ms);
  EXPECT_TRUE(model.state().trusted);

  ClockModel rare{{}};
  Device slow{.period = 1s};
  max_error(rare, slow, 35s);
  EXPECT_FALSE(rare.state().trusted);
}

TEST(ClockModel, IsNotTrustedBeyondTheMaximumSkew) {
  Device device{.skew_ppm = 1000};
  ClockModel model{{}};
  max_error(model, device, 2min);
  EXPECT_FALSE(model.state().trusted);
  EXPECT_STRNE(model.state().reason, "");
}

TEST(ClockModel, AcceptsArbitraryNumbers) {
  std::mt19937_64 random(11);
  const int64_t wild[] = {INT64_MIN, INT64_MIN + 1, -1, 0, 1, INT64_MAX - 1, INT64_MAX};
  for (const Duration modulo : std::vector<Duration>{0ns, 1us, 1h}) {
    ClockModelOptions options;
    options.modulo = modulo;
    if (modulo == 1us) {
      options.max_delay = 100ns;
      options.jump_threshold = 50ns;
    }
    ClockModel model(options);
    for (int i = 0; i < 200'000; ++i) {
      const bool is_wild = random() % 2 == 0;
      const auto device = static_cast<int64_t>(is_wild ? wild[random() % 7] : int64_t(random()));
      const auto host =
          static_cast<int64_t>(random() % 2 == 0 ? wild[random() % 7] : int64_t(random()));
      const int repeats = random() % 10 == 0 ? 5 : 1;
      for (int k = 0; k < repeats; ++k) {
        const Stamp stamp = model.update(Duration(device), Stamp::from_ns(host));
        ASSERT_LE(stamp.ns(), std::max(host, int64_t{-4'000'000'000'000'000'000}));
        model.to_host(Duration(wild[random() % 7]));
      }
    }
    EXPECT_GE(model.state().jitter, 0ns);
  }
}

}  // namespace
}  // namespace infuse
