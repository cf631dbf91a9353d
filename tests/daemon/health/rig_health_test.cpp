#include "daemon/health/rig_health.hpp"

#include <gtest/gtest.h>

namespace infuse::daemon {
namespace {

TEST(RigHealth, AConfiguredRigIsOk) {
  RigHealth health;
  EXPECT_EQ(health.update(Stamp(), {"top"}, {}).level(), Level::kOk);
}

TEST(RigHealth, WithoutSensorsItWarns) {
  RigHealth health;
  const Conditions& conditions = health.update(Stamp(), {}, {});
  EXPECT_EQ(conditions.level(), Level::kWarn);
  EXPECT_STREQ(conditions.findings().at(0).id, "no_sensors");
}

TEST(RigHealth, MissingSensorsAreAnErrorThatNamesThem) {
  RigHealth health;
  HealthOptions options;
  options.expected_sensors = {"top", "front", "bus"};
  const Conditions& conditions = health.update(Stamp(), {"front"}, options);
  EXPECT_EQ(conditions.level(), Level::kError);
  EXPECT_EQ(conditions.findings().at(0).what, "expected but not configured: top, bus");
  EXPECT_EQ(health.update(Stamp(), {"bus", "front", "top"}, options).level(), Level::kOk);
}

}  // namespace
}  // namespace infuse::daemon
