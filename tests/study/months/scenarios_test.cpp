#include "tests/study/months/scenarios.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "daemon/history/history_file.hpp"

namespace infuse::study {
namespace {

class ScenarioTest : public testing::TestWithParam<Scenario> {
 protected:
  /// How far the calibration in use is from the true one, and from the configured one, rad and m.
  static double distance(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
    return geometry::log(a * b.inverse()).norm();
  }

  /// Every raised alert of the daemon is in its history once an hour, and every line is whole.
  static void check_history(const Simulation& simulation, bool damaged) {
    const auto lines = daemon::read_history(simulation.state() / daemon::kHistoryFile);
    ASSERT_TRUE(lines);
    size_t bad = 0;
    for (const std::string& line : *lines) {
      bad += nlohmann::json::parse(line, nullptr, false).is_discarded() ? 1 : 0;
    }
    EXPECT_EQ(bad, damaged ? 1U : 0U);
  }
};

TEST_P(ScenarioTest, RaisesAndClearsItsAlertsAndNoOther) {
  const Scenario& scenario = GetParam();
  Simulation simulation({.seed = 1, .policy = scenario.policy}, parse_faults(scenario.faults));
  const Eigen::Isometry3d configured = simulation.camera().T_used();
  simulation.run_until(scenario.length);
  EXPECT_THAT(compare_alerts(simulation.alerts(), parse_expected(scenario.alerts)),
              testing::IsEmpty())
      << scenario.name;
  EXPECT_THAT(simulation.problems(), testing::IsEmpty()) << scenario.name;
  if (scenario.recordings >= 0) {
    EXPECT_EQ(simulation.recordings(), static_cast<size_t>(scenario.recordings)) << scenario.name;
  }
  if (scenario.calibration != nullptr) {
    const std::string end = scenario.calibration;
    const SimulatedCamera& camera = simulation.camera();
    if (end == "configured") {
      EXPECT_EQ(distance(camera.T_used(), configured), 0) << scenario.name;
    }
    if (end == "true") {
      EXPECT_LT(distance(camera.T_used(), camera.T_true()), 0.03) << scenario.name;
      EXPECT_GT(distance(camera.T_used(), configured), 0.005) << scenario.name;
    }
    if (end == "kept") {
      EXPECT_GT(distance(camera.T_used(), configured), 0.2) << scenario.name;
    }
  }
  const bool damaged = std::string(scenario.faults).find("history damaged") != std::string::npos;
  simulation.finish();
  check_history(simulation, damaged);
}

std::string test_name(const testing::TestParamInfo<Scenario>& scenario) {
  std::string name = scenario.param.name;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); },
      '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Months, ScenarioTest, testing::ValuesIn(scenarios()), test_name);

TEST(Scenarios, ThereAreAtLeastSixty) { EXPECT_GE(scenarios().size(), 60U); }

// The comparison itself can fail.
TEST(CompareAlerts, NamesWhatIsMissingAndWhatIsTooMuch) {
  const std::vector<ObservedAlert> observed = {{60, "a.x", true, daemon::Level::kWarn},
                                               {70, "a.x", false, daemon::Level::kWarn},
                                               {80, "b.y", true, daemon::Level::kWarn}};
  const auto differences = [&](const char* expected) {
    return compare_alerts(observed, parse_expected(expected)).size();
  };
  EXPECT_EQ(differences("a.x 60 70; b.y 80 -"), 0U);
  EXPECT_EQ(differences("a.x 58..61 69..75; b.y 80 *"), 0U);
  EXPECT_EQ(differences("a.x 60 70"), 1U);
  EXPECT_EQ(differences("a.x 61 70; b.y 80 -"), 2U);
  EXPECT_EQ(differences("a.x 60 71; b.y 80 -"), 2U);
  EXPECT_EQ(differences("a.x 60 -; b.y 80 -"), 2U);
  EXPECT_EQ(differences("a.x 60 70; b.y 80 -; c.z 1 2"), 1U);
  EXPECT_EQ(differences("a.x 60 70; b.y 80 -; c.z * *"), 0U);
  EXPECT_EQ(compare_alerts(observed, parse_expected("a.x 60 70"), "b.y").size(), 0U);
}

}  // namespace
}  // namespace infuse::study
