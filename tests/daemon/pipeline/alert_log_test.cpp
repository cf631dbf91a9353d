#include "daemon/pipeline/alert_log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/stamp_at.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

AlertReport report_at(double second, bool raised, Level level = Level::kStale, double since = 10) {
  return {at(second), "top", raised, {"silent", level, at(since), "no data for 3.0 s", "check it"}};
}

std::string value_of(const AlertLine& line, const std::string& name) {
  for (const LogField& field : line.fields) {
    if (field.name == name) return field.value;
  }
  return "";
}

TEST(AlertLog, TellsWhenAnAlertIsRaisedAndCleared) {
  AlertLog log;
  const auto raised = log.line(report_at(10, true));
  ASSERT_TRUE(raised);
  EXPECT_EQ(raised->text, "top.silent raised (STALE): no data for 3.0 s (check it)");
  EXPECT_EQ(raised->level, spdlog::level::err);
  EXPECT_EQ(value_of(*raised, "INFUSE_ALERT"), "top.silent");
  EXPECT_EQ(value_of(*raised, "INFUSE_DEVICE"), "top");
  EXPECT_EQ(value_of(*raised, "INFUSE_LEVEL"), "STALE");
  EXPECT_EQ(value_of(*raised, "INFUSE_STATE"), "raised");
  EXPECT_EQ(value_of(*raised, "INFUSE_ADVICE"), "check it");
  const auto cleared = log.line(report_at(22.5, false));
  ASSERT_TRUE(cleared);
  EXPECT_EQ(cleared->text, "top.silent cleared after 12.5 s: no data for 3.0 s");
  EXPECT_EQ(cleared->level, spdlog::level::warn);
  EXPECT_EQ(value_of(*cleared, "INFUSE_STATE"), "cleared");
  EXPECT_NE(value_of(*cleared, "MESSAGE_ID"), value_of(*raised, "MESSAGE_ID"));
}

TEST(AlertLog, AWarningIsAWarning) {
  EXPECT_EQ(AlertLog().line(report_at(10, true, Level::kWarn))->level, spdlog::level::warn);
  EXPECT_EQ(AlertLog().line(report_at(10, true, Level::kError))->level, spdlog::level::err);
}

// Raised and cleared every 20 s for an hour: three pairs in ten minutes.
TEST(AlertLog, AnAlertThatComesAndGoesIsLeftOutAndCounted) {
  AlertLog log;
  int raised = 0, cleared = 0;
  std::string last;
  for (int second = 0; second < 3600; second += 20) {
    if (const auto line = log.line(report_at(second, true, Level::kWarn, second))) {
      ++raised;
      last = line->text;
    }
    if (log.line(report_at(second + 10, false, Level::kWarn, second))) ++cleared;
  }
  EXPECT_EQ(raised, 6 * AlertLog::kMaxRaised);
  EXPECT_EQ(cleared, raised);
  const auto next = log.line(report_at(3600, true));
  ASSERT_TRUE(next);
  EXPECT_THAT(next->text, HasSubstr("raised 27 times more since the last line"));
  EXPECT_THAT(last, testing::Not(HasSubstr("more")));
}

// The clock of a replay may step back.
TEST(AlertLog, TimeThatStepsBackBeginsAnInterval) {
  AlertLog log;
  for (int i = 0; i < 4; ++i) log.line(report_at(1000 + i, true));
  EXPECT_FALSE(log.line(report_at(1010, true)));
  EXPECT_TRUE(log.line(report_at(5, true)));
}

}  // namespace
}  // namespace infuse::daemon
