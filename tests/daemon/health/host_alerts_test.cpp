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

TEST(HostAlerts, ANewMapThatIsRefusedIsSaidUntilOneIsUsed) {
  AlertChecks<HostStatus> checks(host_alerts(), HealthOptions());
  HostStatus host;
  host.maps = {{"map", "01", ""}, {"streetmap", "02", "is truncated"}};
  checks.update(at(1), host);
  ASSERT_EQ(checks.findings().size(), 1U);
  EXPECT_EQ(checks.findings()[0].what, "the new streetmap is not used: is truncated");
  host.maps[1].problem.clear();
  EXPECT_TRUE(checks.update(at(2), host).findings().empty());
}

TEST(HostAlerts, APtpClockThatTheHostDoesNotFollowIsSaidWhereASensorDoes) {
  const auto findings = [](bool ptp_sensors, std::vector<double> offsets) {
    AlertChecks<HostStatus> checks(host_alerts(), HealthOptions());
    HostStatus host;
    for (const double offset : offsets) host.ptp_clocks.push_back({"ptp0", offset});
    host.ptp_sensors = ptp_sensors;
    for (int second = 0; second < 20; ++second) checks.update(at(second), host);
    return checks.findings();
  };
  EXPECT_TRUE(findings(true, {}).empty());
  EXPECT_TRUE(findings(true, {5, -0.0009}).empty());
  EXPECT_TRUE(findings(false, {0.02}).empty());
  const auto off = findings(true, {5, -0.02});
  ASSERT_EQ(off.size(), 1U);
  EXPECT_STREQ(off[0].id, "ptp_clock");
  EXPECT_EQ(off[0].what,
            "a sensor's clock follows PTP, and the host's clock is 0.02 s off the PTP clock ptp0");
}

}  // namespace
}  // namespace infuse::daemon
