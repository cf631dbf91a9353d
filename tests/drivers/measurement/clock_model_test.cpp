#include "drivers/measurement/clock_model.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace infuse {
namespace {

using namespace std::chrono_literals;

/// 2026-11-20 23:58:00 UTC: two minutes before an hour.
constexpr Stamp kStart = Stamp::from_ns(1'795'219'080'000'000'000);
constexpr Duration kHour = 1h;

/// A simulated device with a known clock. The minimum transport delay is 0, so that the truth can
/// be reached.
struct Device {
  double skew_ppm = 0;          ///< positive: runs fast
  Duration period = 553us;      ///< of its messages, true time
  Duration mean_delay = 200us;  ///< exponential
  Duration phase{0};            ///< of its counter against the hour
  Duration modulo = kHour;
  Stamp now = kStart;  ///< true time of the next message
  std::mt19937 random{7};

  struct Message {
    Stamp truth;
    Duration device;
    Stamp host;
  };

  Message next() {
    const Duration run = now - kStart;
    const auto gained = static_cast<int64_t>(static_cast<double>(run.count()) * skew_ppm * 1e-6);
    int64_t count = now.ns() + gained + phase.count();
    if (modulo > 0ns) count %= modulo.count();
    std::exponential_distribution<double> delay(1.0 / static_cast<double>(mean_delay.count()));
    const Message message{now, Duration(count),
                          now + Duration(static_cast<int64_t>(delay(random)))};
    now += period;
    return message;
  }
};

/// Runs the model and returns the largest error of the stamps once the clock is trusted.
Duration max_error(ClockModel& model, Device& device, Duration span) {
  Duration worst{0};
  const Stamp end = device.now + span;
  while (device.now < end) {
    const Device::Message message = device.next();
    const Stamp stamp = model.update(message.device, message.host);
    EXPECT_LE(stamp, message.host);
    if (!model.state().trusted) continue;
    worst = std::max(worst, std::chrono::abs(stamp - message.truth));
  }
  return worst;
}

class ClockModelSkew : public testing::TestWithParam<double> {};

TEST_P(ClockModelSkew, IsEstimatedAndStampsAreAccurateToMicroseconds) {
  // Two minutes before to two minutes after the hour: the counter wraps in between.
  Device device{.skew_ppm = GetParam()};
  ClockModel model{{}};
  EXPECT_LT(max_error(model, device, 4min), 2us);
  EXPECT_TRUE(model.state().trusted) << model.state().reason;
  EXPECT_STREQ(model.state().reason, "");
  EXPECT_EQ(model.state().source, ClockState::Source::kTopOfHour);
  EXPECT_EQ(model.state().jumps, 0);
  EXPECT_NEAR(model.state().skew_ppm, GetParam(), 0.05);
  EXPECT_NEAR(to_seconds(model.state().jitter), 200e-6, 10e-6);
  // Host time minus device time is minus the time that the device has gained.
  const double gained_s = 240 * GetParam() * 1e-6;
  EXPECT_NEAR(to_seconds(model.state().offset), -gained_s, 2e-6);
}

INSTANTIATE_TEST_SUITE_P(PartsPerMillion, ClockModelSkew,
                         testing::Values(-100.0, -20.0, 0.0, 3.0, 100.0));

TEST(ClockModel, SlowStreamWithLargeDelaysIsAccurateToAFractionOfTheDelay) {
  // A camera: 10 Hz, 2 ms mean delay.
  Device device{.skew_ppm = 40, .period = 100ms, .mean_delay = 2ms, .modulo = 0ns};
  ClockModelOptions options;
  options.modulo = 0ns;
  ClockModel model(options);
  EXPECT_LT(max_error(model, device, 30min), 1500us);  // including the first minute
  EXPECT_LT(max_error(model, device, 30min), 400us);
  EXPECT_NEAR(model.state().skew_ppm, 40, 10);
  EXPECT_EQ(model.state().source, ClockState::Source::kPowerUp);
  EXPECT_EQ(model.state().jumps, 0);
}

TEST(ClockModel, DetectsAndMapsACounterFromPowerUp) {
  for (const Duration phase : std::vector<Duration>{-1430s, 1531s, 1800s, -2s, 3599s}) {
    Device device{.skew_ppm = -30, .phase = kHour + phase};
    ClockModel model{{}};
    EXPECT_LT(max_error(model, device, 3min), 2us);
    EXPECT_TRUE(model.state().trusted);
    // 3599 s after the hour is 1 s before the next.
    EXPECT_EQ(model.state().source, ClockState::Source::kPowerUp);
    EXPECT_EQ(model.state().jumps, 0);
    const Duration in_hour = model.state().offset + phase;
    EXPECT_LT(std::chrono::abs(in_hour - (in_hour > 30min ? kHour : 0h)), 10ms) << phase.count();
  }
}

TEST(ClockModel, AClockThatIsNotACounterAgreesWithTheHostsOrIsNotSet) {
  for (const Duration phase : std::vector<Duration>{0ns, -300ms, 2s}) {
    Device device{.phase = phase, .modulo = 0ns};
    ClockModelOptions options;
    options.modulo = 0ns;
    options.synchronised = ClockState::Source::kPtp;
    ClockModel model(options);
    max_error(model, device, 10s);
    EXPECT_EQ(model.state().source,
              phase == 2s ? ClockState::Source::kPowerUp : ClockState::Source::kPtp);
  }
}

TEST(ClockModel, ToleratesAHostClockHalfASecondOff) {
  Device device{.phase = 400ms};
  ClockModel model{{}};
  max_error(model, device, 10s);
  EXPECT_EQ(model.state().source, ClockState::Source::kTopOfHour);
}

TEST(ClockModel, AcceptsACounterSlightlyPastTheHour) {
  Device device{.skew_ppm = 80};
  ClockModel model{{}};
  Duration worst{0};
  bool passed = false;
  for (int i = 0; i < 300'000; ++i) {
    Device::Message message = device.next();
    if (message.device < 500us) {
      message.device += kHour;
      passed = true;
    }
    const Stamp stamp = model.update(message.device, message.host);
    if (model.state().trusted) worst = std::max(worst, std::chrono::abs(stamp - message.truth));
  }
  EXPECT_TRUE(passed);
  EXPECT_LT(worst, 2us);
  EXPECT_EQ(model.state().jumps, 0);
}

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

TEST(ClockModel, MapsOutOfOrderAndDuplicateMessagesEqually) {
  Device device{.skew_ppm = -60};
  ClockModel model{{}};
  Duration worst{0};
  std::vector<Device::Message> four(4);
  for (int i = 0; i < 100'000; ++i) {
    for (Device::Message& message : four) message = device.next();
    const Stamp received = four[3].host;
    for (const size_t which : {2u, 0u, 0u, 3u, 1u}) {
      const Stamp host = which == 3 ? received : std::max(received, four[which].host);
      const Stamp stamp = model.update(four[which].device, host);
      if (!model.state().trusted) continue;
      worst = std::max(worst, std::chrono::abs(stamp - four[which].truth));
    }
  }
  EXPECT_LT(worst, 10us);
  EXPECT_EQ(model.state().jumps, 0);
}

TEST(ClockModel, BridgesAGapOfAnHourAndAHalf) {
  Device device{.skew_ppm = 30};
  ClockModel model{{}};
  max_error(model, device, 2min);
  device.now += 90min;
  EXPECT_LT(max_error(model, device, 1min), 2ms);
  EXPECT_EQ(model.state().jumps, 0);
}

TEST(ClockModel, KeepsItsAccuracyOverAMillionSamplesInADayAndAHalf) {
  Device device{.skew_ppm = 100, .period = 130ms, .mean_delay = 300us};
  ClockModel model{{}};
  Duration worst{0};
  uint64_t untrusted = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    const Device::Message message = device.next();
    const Stamp stamp = model.update(message.device, message.host);
    if (!model.state().trusted) ++untrusted;
    if (i > 1000) worst = std::max(worst, std::chrono::abs(stamp - message.truth));
  }
  EXPECT_LT(worst, 120us);
  EXPECT_EQ(model.state().jumps, 0);
  EXPECT_LT(untrusted, 1000u);
  // 36 h at 100 ppm: the device is 13 s ahead.
  EXPECT_NEAR(to_seconds(model.state().offset), -13.0, 0.001);
}

TEST(ClockModel, MapsDeviceTimesNearTheLatestWithoutAddingThem) {
  Device device{.skew_ppm = 100};
  ClockModel model{{}};
  max_error(model, device, 3min);  // 1 min past the hour
  const ClockState before = model.state();
  for (const Duration ahead : std::vector<Duration>{-1h / 3, -90s, -1ms, 0ms, 1ms, 10s}) {
    Device other = device;
    other.now += ahead;
    const Device::Message message = other.next();
    const Duration error = model.to_host(message.device) - message.truth;
    // The skew itself is known to 0.05 ppm.
    const Duration bound = 2us + Duration(std::chrono::abs(ahead).count() / 20'000'000);
    EXPECT_LT(std::chrono::abs(error), bound) << ahead.count();
  }
  EXPECT_EQ(model.state().offset, before.offset);
}

TEST(ClockModel, SubtractsTheMinimumDelay) {
  Device device;
  ClockModelOptions options;
  options.min_delay = 1500us;
  ClockModel model(options);
  for (int i = 0; i < 50'000; ++i) {
    const Device::Message message = device.next();
    const Stamp stamp = model.update(message.device, message.host + 1500us);
    if (model.state().trusted) {
      EXPECT_LT(std::chrono::abs(stamp - message.truth), 2us);
    }
  }
  EXPECT_TRUE(model.state().trusted);
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

TEST(ClockModelOptions, ReportsWhatIsInvalid) {
  EXPECT_FALSE(ClockModelOptions{}.invalid());
  const auto wrong = [](auto change) {
    ClockModelOptions options;
    change(options);
    return options.invalid().value_or("nothing");
  };
  EXPECT_THAT(wrong([](auto& o) { o.modulo = -1ns; }), testing::StartsWith("modulo"));
  EXPECT_THAT(wrong([](auto& o) { o.min_delay = -1ns; }), testing::StartsWith("min_delay"));
  EXPECT_THAT(wrong([](auto& o) { o.max_skew_ppm = 0; }), testing::StartsWith("max_skew_ppm"));
  EXPECT_THAT(wrong([](auto& o) { o.max_skew_ppm = NAN; }), testing::StartsWith("max_skew_ppm"));
  EXPECT_THAT(wrong([](auto& o) { o.window = 0ns; }), testing::StartsWith("window"));
  EXPECT_THAT(wrong([](auto& o) { o.settling_time = 2min; }), testing::StartsWith("settling_time"));
  EXPECT_THAT(wrong([](auto& o) { o.jump_threshold = 2s; }), testing::StartsWith("jump_threshold"));
  EXPECT_THAT(wrong([](auto& o) { o.jump_confirmation = -1ns; }),
              testing::StartsWith("jump_confirmation"));
  EXPECT_THAT(wrong([](auto& o) { o.max_delay = 25h; }), testing::StartsWith("max_delay"));
  EXPECT_THAT(wrong([](auto& o) { o.modulo = 1s; }), testing::StartsWith("max_delay"));
  EXPECT_THAT(wrong([](auto& o) { o.hour_tolerance = -1ns; }),
              testing::StartsWith("hour_tolerance"));
}

}  // namespace
}  // namespace infuse
