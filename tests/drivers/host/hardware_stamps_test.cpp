#include "drivers/host/hardware_stamps.hpp"

#include <gtest/gtest.h>

#include <random>

namespace infuse::host {
namespace {

constexpr Stamp kStart = Stamp::from_ns(1'700'000'000'000'000'000);

TEST(HardwareStamps, RemoveTransportDelaysFromStamps) {
  HardwareStamps stamps;
  std::mt19937 random(7);
  std::exponential_distribution<double> late_ms(0.5);
  Duration worst{0}, worst_of_kernel{0};
  Stamp before = Stamp::earliest();
  for (int i = 0; i < 6000; ++i) {  // one minute of frames every 10 ms
    const Stamp sent = kStart + i * Duration(10'000'000);
    // 40 ppm fast, since the interface was plugged in.
    const auto hardware_ns = static_cast<int64_t>(5e9 + i * 1e7 * (1 + 40e-6));
    const Stamp received = sent + Duration(static_cast<int64_t>(late_ms(random) * 1e6));
    const Stamp stamp = stamps.update(hardware_ns, received);
    ASSERT_LE(stamp, received);
    ASSERT_GE(stamp, before);
    before = stamp;
    if (i < 1000) continue;
    worst = std::max(worst, distance_between(stamp, sent));
    worst_of_kernel = std::max(worst_of_kernel, distance_between(received, sent));
  }
  EXPECT_TRUE(stamps.stamped_by_hardware());
  EXPECT_GT(worst_of_kernel, Duration(10'000'000));
  EXPECT_LT(worst, Duration(500'000));
}

// Each interface has a clock of its own.
TEST(HardwareStamps, AnotherInterfaceBeginsAnew) {
  HardwareStamps stamps;
  for (int i = 0; i < 2000; ++i) {
    const Stamp received = kStart + i * Duration(10'000'000);
    const bool second = i >= 1000;
    const int64_t counted = (second ? 900'000'000'000 : 5'000'000'000) + i * int64_t{10'000'000};
    const Stamp stamp = stamps.update(counted, received, second ? 3 : 2);
    ASSERT_LE(stamp, received);
    ASSERT_LT(received - stamp, Duration(1'000'000)) << i;
  }
}

TEST(HardwareStamps, FallsBackToTheKernelsStamps) {
  HardwareStamps stamps;
  EXPECT_EQ(stamps.update(0, kStart), kStart);
  EXPECT_FALSE(stamps.stamped_by_hardware());
}

TEST(HardwareStamps, FollowsAnInterfaceThatRestartsItsCounter) {
  HardwareStamps stamps;
  Stamp stamp;
  for (int i = 0; i < 2000; ++i) {
    const Stamp received = kStart + i * Duration(10'000'000);
    const int64_t counted = i < 1000 ? i : i - 1000;
    stamp = stamps.update(1'000'000'000 + counted * 10'000'000, received);
    ASSERT_LE(stamp, received);
    ASSERT_LT(received - stamp, Duration(1'000'000)) << i;
  }
}

}  // namespace
}  // namespace infuse::host
