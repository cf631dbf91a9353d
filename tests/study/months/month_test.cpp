#include "tests/study/months/month.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/service/history_file.hpp"

namespace infuse::study {
namespace {

// infuse-study months runs thirty of them.
TEST(Month, ADayOfScenariosIsAsTheTableSays) {
  const MonthResult day = simulate_month({.days = 1, .seed = 1, .mean_gap_s = 600});
  EXPECT_THAT(day.differences, testing::IsEmpty());
  EXPECT_THAT(day.problems, testing::IsEmpty());
  EXPECT_GE(day.scenarios, 40U);
  EXPECT_GE(day.raised, 40U);
  EXPECT_LT(day.history * 366, daemon::HistoryFile::kMaxBytes);
}

}  // namespace
}  // namespace infuse::study
