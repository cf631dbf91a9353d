// Every alert is well described, and infused(8) lists them all. With INFUSE_WRITE_MANUAL in the
// environment the manual's list is written instead of compared.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include "daemon/health/alert_checks.hpp"
#include "daemon/health/calibration_health.hpp"
#include "daemon/health/host_alerts.hpp"
#include "daemon/health/lidar_alerts.hpp"
#include "daemon/health/map_health.hpp"
#include "daemon/health/odometry_health.hpp"
#include "daemon/health/rig_health.hpp"
#include "daemon/health/service_alerts.hpp"
#include "daemon/health/stream_alerts.hpp"
#include "daemon/health/streetmap_health.hpp"
#include "tests/folders.hpp"
#include "tests/stamp_at.hpp"

namespace infuse::daemon {
namespace {

/// The alerts of one kind of device, or of one task.
struct AlertGroup {
  const char* title;
  const char* device;  ///< capitals stand for a name
  std::vector<AlertDescription> alerts;
};

template <class Input>
std::vector<AlertDescription> descriptions_of(std::span<const Alert<Input>> alerts) {
  std::vector<AlertDescription> descriptions;
  for (const Alert<Input>& alert : alerts) descriptions.push_back(alert.description);
  return descriptions;
}

std::vector<AlertGroup> all_alerts() {
  return {{"Lidar", "LIDAR", descriptions_of(lidar_alerts())},
          {"Camera, bus, inertial unit, GNSS receiver", "SENSOR", descriptions_of(stream_alerts())},
          {"Odometry", "odometry", descriptions_of(odometry_alerts())},
          {"Calibration", "CAMERA", descriptions_of(calibration_alerts())},
          {"Street map", "streetmap", descriptions_of(streetmap_alerts())},
          {"Map of keyframes", "map", descriptions_of(map_alerts())},
          {"Configured sensors", "infused", descriptions_of(rig_alerts())},
          {"The host", "infused", descriptions_of(host_alerts())},
          {"The service", "infused", {kServiceAlerts.begin(), kServiceAlerts.end()}}};
}

/// Converts a text to man(7): `…` becomes bold, with hyphens that can be copied.
std::string manual_text(const std::string& text) {
  std::string out;
  bool literal = false;
  for (const char c : text) {
    if (c == '`') {
      literal = !literal;
      out += literal ? "\\fB" : "\\fR";
    } else {
      out += c == '-' && literal ? "\\-" : std::string(1, c);
    }
  }
  return out;
}

/// Breaks a text into lines of at most 118 characters.
std::string wrapped(const std::string& text) {
  constexpr size_t kMaxLine = 118;
  std::string lines, line;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (!line.empty() && line.size() + 1 + word.size() > kMaxLine) {
      lines += line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
  }
  return lines + line + "\n";
}

/// The list of the manual, as the alerts describe themselves.
std::string alerts_manual() {
  std::string text;
  for (const AlertGroup& group : all_alerts()) {
    text += fmt::format(".SS {}\n", group.title);
    for (const AlertDescription& alert : group.alerts) {
      text += fmt::format(".TP\n.BR {}.{} \" ({}{})\"\n{}", group.device, alert.id,
                          name_of(alert.level), alert.in_health ? "" : ", not in HEALTH",
                          wrapped(manual_text(alert.about)));
    }
  }
  return text;
}

TEST(Alerts, TheManualListsThem) {
  const std::filesystem::path path =
      std::filesystem::path(source_folder()) / "packaging/man/infused.8";
  std::stringstream file;
  file << std::ifstream(path).rdbuf();
  const std::string manual = file.str();
  const auto section = manual.find(".SH ALERTS\n");
  ASSERT_NE(section, std::string::npos);
  const auto begin = manual.find(".SS ", section), end = manual.find(".SH ", begin);
  ASSERT_NE(end, std::string::npos);
  if (std::getenv("INFUSE_WRITE_MANUAL") != nullptr) {
    std::ofstream(path) << manual.substr(0, begin) << alerts_manual() << manual.substr(end);
    GTEST_SKIP() << "written: " << path;
  }
  EXPECT_EQ(manual.substr(begin, end - begin), alerts_manual())
      << path << ": update it with INFUSE_WRITE_MANUAL=1";
}

TEST(Alerts, AreDescribedAndDistinct) {
  std::set<std::string> ids;
  for (const AlertGroup& group : all_alerts()) {
    for (const AlertDescription& alert : group.alerts) {
      const std::string id = std::string(group.device) + "." + alert.id;
      EXPECT_TRUE(ids.insert(id).second) << id;
      EXPECT_TRUE(std::regex_match(alert.id, std::regex("[a-z]+(_[a-z]+)*"))) << id;
      EXPECT_NE(alert.level, Level::kOk) << id;
      EXPECT_THAT(alert.about, testing::EndsWith(".")) << id;
    }
  }
}

// A list of findings begins with what matters most.
TEST(Alerts, TheWorstAreFirst) {
  for (const AlertGroup& group : all_alerts()) {
    if (!group.alerts.front().in_health) continue;
    for (size_t i = 1; i < group.alerts.size(); ++i) {
      EXPECT_GE(group.alerts[i - 1].level, group.alerts[i].level) << group.alerts[i].id;
    }
  }
}

/// Two alerts of a number: one at once, one after the delays of the configuration.
constexpr Alert<int> kNumberAlerts[] = {
    {{"negative", Level::kError, Delays::kNone, "."},
     [](const int& number) -> std::optional<Problem> {
       if (number >= 0) return {};
       return Problem{fmt::format("{} is negative", number), "add"};
     }},
    {{"odd", Level::kWarn, Delays::kBoth, "."},
     [](const int& number) -> std::optional<Problem> {
       if (number % 2 == 0) return {};
       return Problem{fmt::format("{} is odd", number), "double"};
     }},
};

TEST(AlertChecks, FindingsAreThoseThatHeldForTheirDelay) {
  AlertChecks<int> checks(kNumberAlerts, HealthOptions());  // 2 s to raise, 3 s to clear
  EXPECT_EQ(checks.update(at(0), 3).level(), Level::kOk);
  EXPECT_EQ(checks.update(at(1), -5).findings().at(0).what, "-5 is negative");
  EXPECT_EQ(checks.level(), Level::kError);
  checks.update(at(2), 7);
  EXPECT_EQ(checks.level(), Level::kWarn);
  ASSERT_EQ(checks.transitions().size(), 2U);
  EXPECT_FALSE(checks.transitions()[0].raised);
  EXPECT_EQ(checks.transitions()[0].finding.what, "-5 is negative");
  EXPECT_TRUE(checks.transitions()[1].raised);
  EXPECT_EQ(checks.transitions()[1].finding.what, "7 is odd");
  for (int second = 3; second < 6; ++second) {
    EXPECT_EQ(checks.update(at(second), 2).findings().size(), 1U) << second;
  }
  EXPECT_TRUE(checks.update(at(6), 2).findings().empty());
  ASSERT_EQ(checks.transitions().size(), 1U);
  EXPECT_EQ(checks.transitions()[0].finding.since, at(2));
}

}  // namespace
}  // namespace infuse::daemon
