#include "drivers/measurement/clock_model.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <vector>
#include "tests/drivers/measurement/simulated_device.hpp"

namespace infuse {
namespace {

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
