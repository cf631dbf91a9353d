#include "daemon/health/rig_health.hpp"

#include <gtest/gtest.h>

#include "daemon/health/alert_checks.hpp"

namespace infuse::daemon {
namespace {

using Names = std::vector<std::string>;

/// Findings with these devices configured and these expected.
std::vector<Finding> findings_of(const Names& names, const Names& expected) {
  AlertChecks<RigStatus> checks(rig_alerts(), HealthOptions());
  return checks.update(Stamp(), {names, expected}).findings();
}

TEST(RigHealth, AConfiguredRigIsOk) {
  EXPECT_TRUE(findings_of({"top"}, {}).empty());
  EXPECT_TRUE(findings_of({"bus", "front", "top"}, {"top", "front", "bus"}).empty());
}

TEST(RigHealth, WithoutSensorsItWarns) {
  const auto findings = findings_of({}, {});
  EXPECT_EQ(worst_level(findings), Level::kWarn);
  EXPECT_STREQ(findings.at(0).id, "no_sensors");
}

TEST(RigHealth, MissingSensorsAreAnErrorThatNamesThem) {
  const auto findings = findings_of({"front"}, {"top", "front", "bus"});
  EXPECT_EQ(worst_level(findings), Level::kError);
  EXPECT_EQ(findings.at(0).what, "expected but not configured: top, bus");
}

}  // namespace
}  // namespace infuse::daemon
