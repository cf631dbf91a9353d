#include "daemon/health/host_alerts.hpp"

#include <gtest/gtest.h>

#include "daemon/health/alert_checks.hpp"
#include "tests/stamp_at.hpp"

namespace infuse::daemon {
namespace {

TEST(HostAlerts, AStoreThatCannotBeWrittenIsNamedAtOnce) {
  AlertChecks<HostStatus> checks(host_alerts(), HealthOptions());
  HostStatus host{{{"state", 1 << 30, ""}, {"history", 0, "No space left on device"}}, {}};
  EXPECT_EQ(checks.update(at(1), host).level(), Level::kWarn);
  EXPECT_EQ(checks.findings()[0].what, "history: No space left on device");
  host.stores[1].problem.clear();
  EXPECT_EQ(checks.update(at(2), host).level(), Level::kOk);
  EXPECT_FALSE(checks.transitions()[0].raised);
}

TEST(HostAlerts, AClockThatNothingKeepsIsSaidAfterAWhile) {
  AlertChecks<HostStatus> checks(host_alerts(), HealthOptions());
  const HostStatus unknown, kept{{}, SystemClock{true, 0.01, 0.001}}, free{{}, SystemClock{}};
  for (int second = 0; second < 10; ++second)
    checks.update(at(second), second < 5 ? unknown : kept);
  EXPECT_EQ(checks.level(), Level::kOk);
  for (int second = 10; second < 20; ++second) checks.update(at(second), free);
  ASSERT_EQ(checks.findings().size(), 1U);
  EXPECT_STREQ(checks.findings()[0].id, "system_clock");
}

}  // namespace
}  // namespace infuse::daemon
