#include "fusion/monitoring/delay_ambiguity.hpp"

#include <gtest/gtest.h>

namespace infuse::monitoring {
namespace {

std::optional<Axis> axis_after(int evaluations, const auto& motion) {
  DelayAmbiguity ambiguity;
  for (int k = 0; k < evaluations; ++k) ambiguity.add(motion(k));
  return ambiguity.axis();
}

TEST(DelayAmbiguity, ASteadyTurnMakesADelayLookLikeAYaw) {
  EXPECT_EQ(axis_after(40, [](int) { return Motion{{0, 0.5, 0}, {0, 0, 4}}; }), Axis::kRotationY);
}

TEST(DelayAmbiguity, ASteadySpeedMakesItLookLikeAShiftAhead) {
  EXPECT_EQ(axis_after(40,
                       [](int k) {
                         return Motion{{0, 0, 0}, {0, 0, 9 + 0.1 * (k % 3)}};
                       }),
            Axis::kTranslationZ);
}

TEST(DelayAmbiguity, ChangingRatesAndSpeedsResolveTheAmbiguity) {
  EXPECT_FALSE(axis_after(40, [](int k) {
    return Motion{{0, k % 8 < 4 ? 0.4 : -0.4, 0}, {0, 0, 5}};
  }));
  EXPECT_FALSE(axis_after(40, [](int k) { return Motion{{0, 0, 0}, {0, 0, 4.0 + k % 8}}; }));
}

TEST(DelayAmbiguity, NoAmbiguityWithoutMotionOrEvaluations) {
  EXPECT_FALSE(axis_after(40, [](int) { return Motion{}; }));
  EXPECT_FALSE(axis_after(0, [](int) { return Motion{}; }));
}

}  // namespace
}  // namespace infuse::monitoring
