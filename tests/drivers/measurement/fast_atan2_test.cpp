#include "drivers/measurement/fast_atan2.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "drivers/measurement/angles.hpp"

namespace infuse {
namespace {

TEST(FastAtan2, IsThatOfTheLibrary) {
  double worst = 0;
  for (int i = -20'000; i <= 20'000; ++i) {
    const double angle = i * (std::numbers::pi / 20'000);
    for (const double length : {1e-3, 1.0, 250.0}) {
      const double x = length * std::cos(angle);
      const double y = length * std::sin(angle);
      worst = std::max(worst, std::abs(wrap_angle(fast_atan2(y, x) - std::atan2(y, x))));
    }
  }
  EXPECT_LT(worst, 3e-8);
  EXPECT_EQ(fast_atan2(0, 0), 0);
  EXPECT_EQ(fast_atan2(0, 2), 0);
  EXPECT_NEAR(fast_atan2(0, -2), std::numbers::pi, 1e-15);
}

}  // namespace
}  // namespace infuse
