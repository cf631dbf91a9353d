#include "tests/study/starts/start_study.hpp"

#include <gtest/gtest.h>

namespace infuse::study {
namespace {

TEST(StartStudy, FindsDrawnStartsAndNothingInAnotherTown) {
  StartCounts own, foreign;
  try_drawn_towns(40'500, 1, 1, false, {.length = 700}, own);
  ASSERT_EQ(own.trials.size(), 1U);
  for (const StartTrial& trial : own.trials) {
    EXPECT_TRUE(trial.right_at(650));
    EXPECT_EQ(trial.wrong_metres, 0);
  }
  try_drawn_towns(40'500, 1, 1, true, {.length = 400}, foreign);
  ASSERT_EQ(foreign.trials.size(), 1U);
  EXPECT_LT(foreign.trials[0].sure_after, 0);
}

}  // namespace
}  // namespace infuse::study
