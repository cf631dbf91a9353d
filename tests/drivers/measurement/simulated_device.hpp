#pragma once

#include "drivers/measurement/clock_model.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>

namespace infuse {

using namespace std::chrono_literals;

/// 2026-11-20 23:58:00 UTC: two minutes before an hour.
inline constexpr Stamp kStart = Stamp::from_ns(1'795'219'080'000'000'000);
inline constexpr Duration kHour = 1h;

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
inline Duration max_error(ClockModel& model, Device& device, Duration span) {
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

}  // namespace infuse
