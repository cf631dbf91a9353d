#include "tests/study/months/month.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/history/history_file.hpp"

namespace infuse::study {
namespace {

// infuse-study months runs thirty days of them.
TEST(Month, HoursOfScenariosAreAsTheTableSays) {
  const MonthResult hours = simulate_month({.days = 0.2, .seed = 1, .mean_gap_s = 60});
  EXPECT_THAT(hours.differences, testing::IsEmpty());
  EXPECT_THAT(hours.problems, testing::IsEmpty());
  EXPECT_GE(hours.scenarios, 12U);
  EXPECT_GE(hours.raised, 12U);
  EXPECT_LT(hours.history * 5 * 366, daemon::HistoryFile::kMaxBytes);
}

}  // namespace
}  // namespace infuse::study
